// Tables that sort by any column.

/**
 * A sortable table in a box that scrolls. `columns`: {title, value(row), node(row, value), text, group};
 * `value` is what a column sorts by, `node` what it shows, `text` aligns left and sorts as text. A row with
 * `reason(row)` shows its `text` columns and then that, and stays below the others.
 */
function sortableTable(caption, columns, rows, reason = () => null) {
  const body = element('tbody');
  const headers = columns.map((column) => {
    const button = element('button', {type: 'button'}, column.title);
    const header = element(
        'th', {scope: 'col', 'aria-sort': 'none', class: column.text ? 'text' : null, title: column.about},
        button);
    button.addEventListener('click', () => sortBy(column, header));
    return header;
  });
  const fill = (sorted) => body.replaceChildren(...sorted.map((row) => tableRow(columns, row, reason(row))));

  function sortBy(column, header) {
    const descending = header.getAttribute('aria-sort') === 'ascending';
    headers.forEach((other) => other.setAttribute('aria-sort', 'none'));
    header.setAttribute('aria-sort', descending ? 'descending' : 'ascending');
    const value = (row) => (reason(row) !== null && !column.text ? null : column.value(row) ?? null);
    const missing = (row) => value(row) === null || Number.isNaN(value(row));
    const compare = (a, b) => {
      if (missing(a) || missing(b)) return missing(a) - missing(b);
      const order = column.text ? String(value(a)).localeCompare(String(value(b)), 'en', {numeric: true}) :
                                  Math.sign(value(a) - value(b)) || 0;
      return descending ? -order : order;
    };
    fill([...rows].sort(compare));
  }

  fill(rows);
  const table =
      element('table', {}, element('thead', {}, groupRow(columns), element('tr', {}, headers)), body);
  return element('div', {class: 'scroll', tabindex: '0', role: 'region', 'aria-label': caption}, table);
}

/** Headers over several columns, where columns belong to groups. */
function groupRow(columns) {
  if (!columns.some((column) => column.group)) return null;
  const row = element('tr');
  for (let i = 0; i < columns.length;) {
    let end = i + 1;
    while (end < columns.length && columns[end].group === columns[i].group) ++end;
    const group = columns[i].group;
    row.append(
        group ? element('th', {scope: 'colgroup', class: 'group', colspan: end - i}, group) :
                element('td', {colspan: end - i}));
    i = end;
  }
  return row;
}

function tableRow(columns, row, reason) {
  const shown = reason === null ? columns : columns.filter((column) => column.text);
  const cells = shown.map((column, i) => {
    const value = column.value(row);
    const content = column.node ? column.node(row, value) : value ?? '–';
    return i === 0 ? element('th', {scope: 'row'}, content) :
                     element('td', {class: column.text ? 'text' : null}, content);
  });
  if (reason !== null)
    cells.push(element('td', {class: 'reason bad', colspan: columns.length - shown.length}, reason));
  return element('tr', {class: reason === null ? null : 'failed'}, cells);
}

const spread = (cell) => (median(cell) > 0 ? (cell.seconds.most - cell.seconds.least) / median(cell) : null);

const wideSpread = 0.25;

const failure = (cell) =>
    (isDone(cell) ? null : `${cell.status ?? 'failed'}${cell.error ? `: ${cell.error}` : ''}`);

/** All that was measured of `cells`; columns that no cell has a value for are left out. */
function cellTable(caption, cells, families, leading = []) {
  const family = (cell) => families.get(cell.method);
  const number = (title, about, value, format) =>
      ({title, about, value, node: (row, found) => format(found)});
  const columns = [
    {
      title: 'Method',
      text: true,
      value: (cell) => family(cell).name,
      node: (cell, name) => element('span', {}, swatch(family(cell), false), ` ${name}`)
    },
    ...leading,
    {
      title: 'Setting',
      text: true,
      value: (cell) => cell.setting ?? '',
      node: (cell, text) =>
          [text || '–',
           cell.pareto ? element('span', {class: 'soft', title: 'On the Pareto front'}, ' ◂ front') : null]
    },
    number('Time, s', 'Median of the repeats', median, short),
    {
      title: 'Spread',
      about: 'From the fastest repeat to the slowest, as a share of the median',
      value: spread,
      node: (cell, share) => share > wideSpread ?
          element('span', {class: 'bad wide', title: 'The machine did other work: take the time for a rough one'},
                  `${percent(share)} ⚠`) :
          percent(share)
    },
    number('RMSE', 'Linear RGB', (cell) => cell.rmse, short),
    number(
        'PSNR, dB', '', (cell) => measures[1].of(cell),
        (value) => (value === Infinity ? '∞' : fixed(1)(value))),
    number('SSIM', 'Structural similarity, 1 at best', (cell) => cell.ssim, fixed(5)),
    number('FLIP', 'Mean perceived difference, 0 at best', (cell) => cell.flip, short),
    number('Largest difference', 'Worst channel of the worst pixel, linear', (cell) => cell.max_abs, short),
    number(
        'Beyond 1/255', 'Share of pixels off by more than 1/255', (cell) => cell.share_over_1_255, percent),
    number('Fragments, million', '', (cell) => cell.fragments, millions),
    number('Events, million', '', (cell) => cell.events, millions),
    number('Rays, million', '', (cell) => cell.rays, millions),
    number('Peak memory, MiB', '', (cell) => cell.peak_memory_bytes, mebibytes),
  ];
  const kept = columns.filter(
      (column) => column.text ||
          cells.some(
              (cell) => isDone(cell) && column.value(cell) !== null && column.value(cell) !== undefined));
  return sortableTable(caption, kept, cells, failure);
}

/** Heinzle's Table 1: sub-frames against stills at equal quality, beside the paper's ratio. */
function tableOne(rows) {
  const number = (group, title, value, format) =>
      ({group, title, value, node: (row, found) => format(found)});
  // A quality that no number of stills reached is said so, not left blank.
  const reached = (key, part) => (row) => row[key]?.[part];
  const equal = (group, key) =>
      [{
        group,
        title: 'Stills',
        value: reached(key, 'stills'),
        node: (row, found) => (row[key] ? whole(found) : 'not reached')
      },
       number(group, 'Time, s', reached(key, 'seconds'), short),
       number(group, 'Ratio', reached(key, 'ratio'), fixed(2))];
  const paper = 'Heinzle et al. 2010';
  return sortableTable(
      'Table 1 of Heinzle et al. 2010, measured here and as printed',
      [
        {title: 'Figure', text: true, value: (row) => row.figure ?? row.scene},
        {title: 'Scene', text: true, value: (row) => row.scene},
        number('Six passes', 'Points', (row) => row.points, whole),
        number('Six passes', 'Sub-frames', (row) => row.subframes, whole),
        number('Six passes', 'Time, s', (row) => row.seconds, short),
        number('Six passes', 'PSNR, dB', (row) => row.psnr_db, fixed(1)),
        number('Six passes', 'SSIM', (row) => row.ssim, fixed(4)),
        ...equal('Stills of equal PSNR', 'equal_psnr'),
        ...equal('Stills of equal SSIM', 'equal_ssim'),
        number(paper, 'Sub-frames', (row) => row.paper?.subframes, whole),
        number(paper, 'Stills', (row) => row.paper?.stills, whole),
        number(paper, 'Million points/s', (row) => row.paper?.subframe_mpoints_per_s, fixed(2)),
        number(paper, '… of stills', (row) => row.paper?.still_mpoints_per_s, fixed(2)),
        number(paper, 'Ratio', (row) => row.paper?.ratio, fixed(2)),
      ],
      rows, (row) => (row.error ? `failed: ${row.error}` : null));
}
