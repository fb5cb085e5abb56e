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

/** The method that reaches an accuracy on most scenes, of these the fastest, and what the next one takes. */
function verdictOf(scenes, families) {
  const goal = goals.find(
      (wanted) => 2 * scenes.filter((scene) => fastestOf(scene, wanted).size > 1).length >= Math.max(1, scenes.length));
  if (!goal || scenes.length === 0)
    return 'No two methods reach the same accuracy on half of the scenes, so that none is called the fastest. ' +
        'What each reached, and in what time, is in the plots and tables.';
  const times = scenes.map((scene) => fastestOf(scene, goal));
  const reached = [...families.keys()]
                      .map((id) => ({id, own: times.filter((least) => least.has(id)).map((least) => least.get(id))}))
                      .filter(({own}) => own.length > 0);
  reached.sort((a, b) => b.own.length - a.own.length || geometricMean(a.own) - geometricMean(b.own));
  const {id: best, own} = reached[0];
  const first = times.filter((least) => least.has(best) && least.get(best) === Math.min(...least.values())).length;
  const name = (id) => families.get(id).name;
  const opening = `${name(best)} reaches ${goal} dB on ${whole(own.length)} of ${plural(scenes.length, 'scene')}, in ${
      duration(geometricMean(own))} in the geometric mean, and on ${whole(first)} of them before all others.`;
  const others = [...families.keys()].filter((id) => id !== best).flatMap((id) => {
    const ratios = times.filter((least) => least.has(best) && least.has(id))
                       .map((least) => least.get(id) / least.get(best));
    return ratios.length > 0 ? [{id, ratio: geometricMean(ratios), count: ratios.length}] : [];
  });
  if (others.length === 0) return `${opening} No other method reaches that where it does.`;
  others.sort((a, b) => a.ratio - b.ratio);
  const {id, ratio, count} = others[0];
  return `${opening} Next comes ${name(id)}, which takes ${short(ratio)} times as long (on the ${
      whole(count)} that both reach).`;
}
