// What the study says, in two sentences.

const goals = [80, 60, 50, 40, 30, 20];  // dB, of which the highest that tells methods apart is asked

/** By method, the least time in which a scene's cells reach `goal`. */
function fastestOf(scene, goal) {
  const least = new Map();
  for (const cell of listOf(scene.cells)) {
    const time = median(cell);
    if (!isDone(cell) || !(time > 0) || !(measures[1].of(cell) >= goal)) continue;
    least.set(cell.method, Math.min(time, least.get(cell.method) ?? Infinity));
  }
  return least;
}

const geometricMean = (values) => Math.exp(values.reduce((sum, v) => sum + Math.log(v), 0) / values.length);

/** The method that reaches an accuracy first on most scenes, and what the next one takes. */
function verdictOf(scenes, families) {
  const goal = goals.find(
      (wanted) => 2 * scenes.filter((scene) => fastestOf(scene, wanted).size > 1).length >= Math.max(1, scenes.length));
  if (!goal || scenes.length === 0)
    return 'No two methods reach the same accuracy on half of the scenes, so that none is called the fastest. ' +
        'What each reached, and in what time, is in the plots and tables.';
  const times = scenes.map((scene) => fastestOf(scene, goal));
  const wins = new Map();
  for (const least of times) {
    const [first] = [...least].sort((a, b) => a[1] - b[1]);
    if (first) wins.set(first[0], (wins.get(first[0]) ?? 0) + 1);
  }
  const [[best, won]] = [...wins].sort((a, b) => b[1] - a[1]);
  const own = times.filter((least) => least.has(best)).map((least) => least.get(best));
  const name = (id) => families.get(id).name;
  const first = `${name(best)} reaches ${goal} dB first on ${whole(won)} of ${plural(scenes.length, 'scene')}, in ${
      duration(geometricMean(own))} (geometric mean of the ${whole(own.length)} on which it does).`;
  const others = [...families.keys()].filter((id) => id !== best).flatMap((id) => {
    const ratios = times.filter((least) => least.has(best) && least.has(id))
                       .map((least) => least.get(id) / least.get(best));
    return ratios.length > 0 ? [{id, ratio: geometricMean(ratios), count: ratios.length}] : [];
  });
  if (others.length === 0) return `${first} No other method reaches that where it does.`;
  others.sort((a, b) => a.ratio - b.ratio);
  const {id, ratio, count} = others[0];
  return `${first} Next comes ${name(id)}, which takes ${short(ratio)} times as long (on the ${
      whole(count)} that both reach).`;
}
