// Accuracy against time: one plot for each scene, and what all plots share around them.

const isDone = (cell) => cell.status === 'done';
const median = (cell) => cell.seconds?.median;

/** The families that occur in `cells`, as buttons that show and hide them. `hidden`: ids of those hidden. */
function legend(families, cells, hidden, changed) {
  const used = [...families.values()].filter((family) => cells.some((cell) => cell.method === family.id));
  const items = used.map((family) => {
    const button = element(
        'button', {type: 'button', 'aria-pressed': 'true', title: family.description}, swatch(family, true),
        family.label);
    button.addEventListener('click', () => {
      if (!hidden.delete(family.id)) hidden.add(family.id);
      button.setAttribute('aria-pressed', String(!hidden.has(family.id)));
      changed();
    });
    return element('li', {}, button);
  });
  return element('ul', {class: 'legend', 'aria-label': 'Methods shown'}, items);
}

/** A labelled list to choose from; `options`: [value, text]. */
function chooser(label, options, chosen, changed) {
  const select = element(
      'select', {},
      options.map(([value, text]) => element('option', {value, selected: value === chosen}, text)));
  select.addEventListener('change', () => changed(select.value));
  return element('label', {}, label, select);
}

/** A cell in the words of a tooltip. */
function hoverText(family, cell) {
  const {seconds = {}} = cell;
  const lines = [
    `<b>${escaped(fullName(family, cell))}</b>`,
    `${duration(seconds.median)} (${duration(seconds.least)} to ${duration(seconds.most)})`,
    `RMSE ${short(cell.rmse)}, PSNR ${cell.rmse === 0 ? '∞' : fixed(1)(cell.psnr_db)} dB`,
  ];
  if (isNumber(cell.ssim)) lines.push(`SSIM ${cell.ssim.toFixed(5)}`);
  if (isNumber(cell.flip)) lines.push(`FLIP ${short(cell.flip)}`);
  if (isNumber(cell.max_abs)) lines.push(`largest difference ${short(cell.max_abs)}`);
  return lines.join('<br>');
}

/** The cells that no other beats in both time and this measure. */
function paretoFront(cells, measure) {
  if (measure.id === 'rmse' || measure.id === 'psnr_db') return cells.filter((cell) => cell.pareto === true);
  let least = Infinity;
  return [...cells].sort((a, b) => median(a) - median(b) || measure.of(a) - measure.of(b)).filter((cell) => {
    if (!(measure.of(cell) < least)) return false;
    least = measure.of(cell);
    return true;
  });
}

/** The reference's own error in a measure's units; null where it is not known or there is none. */
function ownError(reference, measure) {
  const value = reference ? measure.of(reference) : null;
  return isNumber(value) && (!measure.log || value >= measure.least) ? value : null;
}

/** What Plot draws for a scene. */
function sceneSpec(scene, families, measure, hidden) {
  const cells = listOf(scene.cells);
  const drawable = (cell) =>
      isDone(cell) && isNumber(median(cell)) && measure.of(cell) !== null && measure.of(cell) !== undefined;
  const pointOf = (family, cell) => ({
    x: median(cell),
    y: measure.of(cell),
    low: cell.seconds.least,
    high: cell.seconds.most,
    cell,
    label: tag(family, cell),
    brief: String(cell.label || family.short),
    hover: hoverText(family, cell),
  });
  const series =
      [...families.values()]
          .map((family) => ({
                 id: family.id,
                 family,
                 hidden: hidden.has(family.id),
                 points: cells.filter((cell) => cell.method === family.id)
                             .map((cell) => (drawable(cell) ? pointOf(family, cell) : {broken: true, cell})),
               }))
          .filter(({points}) => points.some((point) => !point.broken));
  const visible = cells.filter((cell) => drawable(cell) && !hidden.has(cell.method));
  const own = ownError(scene.reference, measure);
  return {
    x: {title: 'Time, median, s', log: true},
    y: {
      title: measure.name,
      log: measure.log,
      least: measure.least,
      better: measure.log ? 'low' : 'high',
      none: measure.log ? '0' : '∞'
    },
    bars: 'x',
    series,
    front: paretoFront(visible, measure).map((cell) => ({x: median(cell), y: measure.of(cell)})),
    untold: own === null ? null : {
      y: own,
      brief: 'reference’s own error',
      text: 'the reference’s own error: what lies beyond cannot be told apart'
    },
  };
}

/** Measures that at least one result has. */
const measuresIn = (cells) =>
    measures.filter((measure) => cells.some((cell) => isDone(cell) && isNumber(measure.of(cell))));

const noPlots = () => element(
    'p', {class: 'note'},
    'Plots are left out: this program was built without its plotting library. The tables hold the same numbers.');

/**
 * A plot with its controls and caption. `specOf(measure, hidden)`; without `choices` there is no measure to
 * choose.
 */
function plotFigure(id, title, families, cells, choices, specOf, caption, low) {
  if (typeof Plotly === 'undefined') return noPlots();
  const hidden = new Set();
  let measure = choices?.[0];
  const about = element('p', {class: 'soft small'}, measure?.about ?? '');
  const note = element(
      'figcaption', {id: `${id}-how`},
      element(
          'details', {open: plots.length === 0}, element('summary', {}, 'How to read this plot'), caption));
  const host = element(
      'div',
      {id, class: low ? 'plot low' : 'plot', role: 'group', 'aria-label': title, 'aria-describedby': note.id});
  const plot = new Plot(host, () => specOf(measure, hidden));
  const select = choices ? chooser(
                               'Judge by', choices.map(({id: value, name}) => [value, name]), measure?.id,
                               (value) => {
                                 measure = choices.find((choice) => choice.id === value);
                                 about.textContent = measure.about;
                                 plot.change();
                               }) :
                           null;
  const controls =
      element('div', {class: 'controls'}, select, legend(families, cells, hidden, () => plot.change()));
  return element('figure', {}, controls, choices ? about : null, host, note);
}

function scenePlot(scene, families) {
  const cells = listOf(scene.cells), choices = measuresIn(cells);
  if (choices.length === 0) return null;
  const failed = cells.filter((cell) => !isDone(cell)).length;
  return plotFigure(
      `plot-${scene.id}`, `Accuracy against time, ${scene.title ?? scene.id}`, families, cells, choices,
      (measure, hidden) => sceneSpec(scene, families, measure, hidden), [
        'Each point is one method at one setting. Further left is faster; further down (for PSNR, up) is more ' +
            'accurate. Both axes are logarithmic, but for PSNR, which is a logarithm. Bars run from the fastest to the slowest ' +
            'repeat. The broad grey steps are the Pareto front: no other result is both faster and more accurate than one on it. ' +
            'In the grey area results differ from the reference by no more than the reference differs from the truth. A result ' +
            'with no error at all stands at the axis’s end. Drag to zoom, double-click to return.',
        failed > 0 ? ` ${plural(failed, 'result')} failed and cannot be drawn; the table says why.` : ''
      ]);
}
