// Error and cost against one quantity that grows: motion length, number of points.

/** What Plot draws: a line for each method and setting, labelled at its end. `rows`: {[key], cells}. */
function seriesSpec(rows, key, title, families, hidden, measure) {
  const sorted = [...rows].sort((a, b) => a[key] - b[key]);
  const ids = new Map();
  for (const row of sorted) {
    for (const cell of listOf(row.cells)) ids.set(`${cell.method} ${cell.id}`, cell);
  }
  const valueOf = (cell) => (measure ? measure.of(cell) : median(cell));
  const series =
      [...ids]
          .map(([id, any]) => {
            const family = families.get(any.method);
            const points = sorted.map((row) => {
              const cell =
                  listOf(row.cells).find((candidate) => `${candidate.method} ${candidate.id}` === id);
              const value = cell && isDone(cell) ? valueOf(cell) : null;
              if (value === null || value === undefined || (!measure && !isNumber(value)))
                return {broken: true};
              return {
                x: row[key],
                y: value,
                low: cell.seconds?.least,
                high: cell.seconds?.most,
                hover: `${escaped(title)} ${short(row[key])}<br>${hoverText(family, cell)}`
              };
            });
            const last = points.findLast((point) => !point.broken);
            if (last)
              Object.assign(last, {label: tag(family, any), brief: String(any.label || family.short)});
            return {id, family, hidden: hidden.has(family.id), points};
          })
          .filter(({points}) => points.some((point) => !point.broken));
  return {
    x: {title, log: true, none: '0'},
    y: measure ? {
      title: measure.name,
      log: measure.log,
      least: measure.least,
      better: measure.log ? 'low' : 'high',
      none: measure.log ? '0' : '∞'
    } :
                 {title: 'Time, median, s', log: true},
    bars: measure ? null : 'y',
    series,
    front: [],
    untold: null,
    column: true,
  };
}

/** What of the rows could not be drawn, in words. */
function failuresOf(rows, key, unit, families) {
  const lines = rows.flatMap(
      (row) => listOf(row.cells)
                   .filter((cell) => !isDone(cell))
                   .map(
                       (cell) => element(
                           'li', {},
                           `${fullName(families.get(cell.method), cell)} at ${short(row[key])} ${unit}: ${
                               failure(cell)}`)));
  return lines.length > 0 ? element('ul', {class: 'bad small'}, lines) : null;
}

/** Rows by scene, in order of appearance. */
function byScene(rows) {
  const groups = new Map();
  for (const row of rows) groups.set(row.scene, [...(groups.get(row.scene) ?? []), row]);
  return groups;
}

/**
 * A section on how something grows. `parts`: the plots to draw, each {id, heading, measured, caption};
 * `measured` judges accuracy instead of time.
 */
function growthSection(id, heading, lead, rows, key, unit, title, families, parts) {
  const section = element(
      'section', {id, 'aria-labelledby': `${id}-title`}, element('h2', {id: `${id}-title`}, heading),
      element('p', {}, lead));
  const groups = byScene(rows);
  for (const [scene, own] of groups) {
    const cells = own.flatMap((row) => listOf(row.cells));
    const name = `${id}-${scene ?? 'scene'}`;
    for (const part of parts) {
      const choices = part.measured ? measuresIn(cells) : null;
      if (choices?.length === 0) continue;
      const said = groups.size > 1 ? `${part.heading}: ${scene}` : part.heading;
      section.append(
          element('h3', {}, said),
          plotFigure(
              `${name}-${part.id}`, said, families, cells, choices,
              (measure, hidden) => seriesSpec(own, key, title, families, hidden, measure), part.caption,
              true));
    }
    const flat = own.flatMap((row) => listOf(row.cells).map((cell) => ({...cell, at: row[key]})));
    const leading = [{title, value: (cell) => cell.at, text: true, node: (cell, value) => short(value)}];
    section.append(
        ...[failuresOf(own, key, unit, families)].filter(Boolean),
        element(
            'details', {}, element('summary', {}, `The numbers behind it${scene ? `: ${scene}` : ''}`),
            cellTable(`${heading}${scene ? `, ${scene}` : ''}`, flat, families, leading)));
  }
  return section;
}

const readLines = 'Each line is one method at one setting, named at its end; axes are logarithmic. ';

function motionSection(rows, families) {
  return growthSection(
      'motion-length', 'As the motion grows',
      'The same scene with more and more motion during the exposure, in pixels (median over the points).',
      rows, 'motion_px', 'px', 'Motion, px', families, [
        {
          id: 'error',
          heading: 'Error against motion length',
          measured: true,
          caption: readLines +
              'A method that samples time loses accuracy as the motion grows; a level line is one that does not.'
        },
        {
          id: 'cost',
          heading: 'Cost against motion length',
          measured: false,
          caption: readLines +
              'Bars run from the fastest to the slowest repeat. A slope of one means that time grows in proportion to the motion.'
        }
      ]);
}

function pointsSection(rows, families) {
  return growthSection(
      'point-count', 'As the points grow',
      'The same scene with more and more points, their radii smaller accordingly.', rows, 'points', 'points',
      'Points', families, [{
        id: 'cost',
        heading: 'Cost against point count',
        measured: false,
        caption: readLines +
            'Bars run from the fastest to the slowest repeat. A slope of one means that time grows in proportion to the points.'
      }]);
}
