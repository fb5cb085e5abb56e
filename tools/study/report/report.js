// The page from top to bottom, from the study's document.

const study = JSON.parse(document.getElementById('study').textContent);
const families = familiesOf(study);
const scenes = listOf(study.scenes);
const anchor = (scene) => `scene-${scene.id}`;

function headOf() {
  const cells = scenes.flatMap((scene) => listOf(scene.cells));
  const failed = cells.filter((cell) => !isDone(cell)).length;
  const methods = new Set(cells.map((cell) => cell.method)).size;
  const samples = study.settings?.reference_samples;
  const repeats = study.settings?.repeats;
  const parts = [
    `${plural(methods, 'method')} at their settings on ${plural(scenes.length, 'scene')}: ${
        plural(cells.length, 'result')}` +
        (failed > 0 ? `, of which ${whole(failed)} failed.` : '.'),
    `Run on ${date(study.started)}${isNumber(study.seconds) ? ` in ${duration(study.seconds)}` : ''}` +
        (study.machine?.cpu ? ` on ${study.machine.cpu}` : '') +
        (study.software ? `, by ${study.software}.` : '.'),
    isNumber(repeats) ? `Times are medians of ${plural(repeats, 'repeat')}.` : null,
    `Every picture is judged, in linear RGB, against the mean of ${
        isNumber(samples) ? whole(samples) : 'many'} still ` +
        'images in double precision; that reference has an error of its own, which each plot shows.',
  ];
  return [
    element('h1', {}, study.title ?? 'What accuracy costs in time'),
    ...(cells.length > 0 ? [element('p', {class: 'verdict'}, verdictOf(scenes, families))] : []),
    element('p', {}, parts.filter(Boolean).join(' '))
  ];
}

/** Why a method has no results, if it has none. */
function withoutResults(method) {
  const holders = [study.scenes, study.motion_length, study.point_count].flatMap(listOf);
  const cells = holders.flatMap((holder) => listOf(holder.cells)).filter((cell) => cell.method === method.id);
  if (cells.some(isDone)) return [];
  const failed = cells.find((cell) => cell.error);
  const reason = failed?.error ?? method.missing ?? 'it was not asked for (--methods, --parts, --quick)';
  return [element('span', {class: 'bad'}, ` No results: ${reason}.`)];
}

function methodsSection() {
  if (listOf(study.methods).length === 0) return null;
  const items = study.methods.flatMap((method) => {
    const family = families.get(method.id);
    return [
      element('dt', {}, swatch(family, true), ` ${family.label}`),
      element('dd', {}, method.description ?? '', ...withoutResults(method))
    ];
  });
  return element('details', {id: 'methods'}, element('summary', {}, 'The methods'), element('dl', {}, items));
}

function factsOf(scene) {
  const {reference} = scene;
  const facts = [
    isNumber(scene.points) ? `${whole(scene.points)} points` : null,
    isNumber(scene.width) && isNumber(scene.height) ? `${scene.width} × ${scene.height} pixels` : null,
    isNumber(scene.motion_px?.median) ? `motion ${short(scene.motion_px.median)} px (median), ${
                                            short(scene.motion_px.largest)} px (largest)` :
                                        null,
    reference ? `reference: ${isNumber(reference.samples) ? whole(reference.samples) + ' stills in ' : ''}${
                    duration(reference.seconds)}` +
            (isNumber(reference.psnr_db) ? `, own error ${fixed(1)(reference.psnr_db)} dB` : '') :
                                           null,
    scene.file ?? null,
  ];
  return element('p', {class: 'soft'}, facts.filter(Boolean).join(' · '));
}

function sceneSection(scene) {
  const id = anchor(scene), title = scene.title ?? scene.id;
  const part = (heading, content) => (content ? [element('h3', {}, heading), content] : []);
  const cells = listOf(scene.cells);
  return element(
      'section', {id, 'aria-labelledby': `${id}-title`}, element('h2', {id: `${id}-title`}, title),
      factsOf(scene), part('Accuracy against time', scenePlot(scene, families)),
      part('Pictures', pictureSection(scene, families, study.difference_scale)),
      part('All measures', cells.length > 0 ? cellTable(`All measures of ${title}`, cells, families) : null));
}

function tableOneSection(rows) {
  return element(
      'section', {id: 'table-1', 'aria-labelledby': 'table-1-title'},
      element('h2', {id: 'table-1-title'}, 'Table 1 of Heinzle et al. 2010, redone'),
      element(
          'p', {},
          'The six passes at the paper’s numbers of points, against the mean of as many still images as it takes to be as ' +
              'accurate. A ratio is the time of the stills over the time of the six passes: above 1 the six passes are faster. The ' +
              'paper’s ratio is that of its points per second, at what its authors judged to be equal visual quality on their GPU.'),
      tableOne(rows));
}

/** "reference_samples" as "reference samples"; true and false in words. */
const keyText = (key) => key.replaceAll('_', ' ');
const valueText = (value) =>
    (value === true                ? 'yes' :
         value === false           ? 'no' :
         value === null            ? 'none' :
         typeof value === 'object' ? JSON.stringify(value) :
                                     String(value));

function runSection() {
  const machine = study.machine ?? {};
  const facts = [
    ['Processor', machine.cpu],
    ['Threads', machine.threads],
    ['Memory', isNumber(machine.memory_bytes) ? `${short(machine.memory_bytes / 2 ** 30)} GiB` : null],
    ['GPU', 'gpu' in machine ? machine.gpu ?? 'none' : null],
    ['System', machine.os],
    ['Compiler', machine.compiler],
    ['Software', study.software],
    ['Started', study.started ? date(study.started) : null],
    ['Took', isNumber(study.seconds) ? duration(study.seconds) : null],
    ...Object.entries(study.settings ?? {}).map(([key, value]) => [keyText(key), valueText(value)]),
  ].filter(([, value]) => value !== null && value !== undefined);
  const save = element('button', {type: 'button'}, 'Save the data (JSON)');
  save.addEventListener('click', () => {
    const link = element('a', {
      download: 'study.json',
      href: URL.createObjectURL(new Blob([JSON.stringify(study, null, 1)], {type: 'application/json'}))
    });
    link.click();
    URL.revokeObjectURL(link.href);
  });
  return element(
      'section', {id: 'run', 'aria-labelledby': 'run-title'},
      element('h2', {id: 'run-title'}, 'The machine and the command'),
      study.command ?
          element('pre', {tabindex: '0', role: 'region', 'aria-label': 'Command'}, element('code', {}, study.command)) :
          null,
      element(
          'dl', {},
          facts.flatMap(([key, value]) => [element('dt', {}, key), element('dd', {}, String(value))])),
      save);
}

/** Sections with their titles in the contents; a list that is empty or absent has none. */
function sections() {
  const made = scenes.map((scene) => [anchor(scene), scene.title ?? scene.id, sceneSection(scene)]);
  const motion = listOf(study.motion_length), points = listOf(study.point_count),
        table = listOf(study.table1);
  if (motion.length > 0) made.push(['motion-length', 'Motion length', motionSection(motion, families)]);
  if (points.length > 0) made.push(['point-count', 'Point count', pointsSection(points, families)]);
  if (table.length > 0) made.push(['table-1', 'Table 1', tableOneSection(table)]);
  if (listOf(study.traversal?.rows).length > 0)
    made.push(['traversal', 'Traversals', traversalSection(study.traversal)]);
  for (const table of listOf(study.mesh_tables)) made.push([table.id, table.title, studyTableSection(table)]);
  made.push(['run', 'Machine and command', runSection()]);
  return made;
}

const made = sections();
const contents = element(
    'nav', {'aria-label': 'Contents'},
    element('ul', {}, made.map(([id, title]) => element('li', {}, element('a', {href: `#${id}`}, title)))));
const methods = methodsSection();
document.getElementById('head').append(...headOf(), ...(methods ? [methods] : []), contents);
document.getElementById('report').append(...made.map(([, , section]) => section));
