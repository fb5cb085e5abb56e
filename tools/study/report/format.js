// Elements, numbers as text, and how each family of methods looks.

/**
 * An element; attributes that are null or false are left out, children may be text, nodes or lists of them.
 */
function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== null && value !== undefined && value !== false)
      made.setAttribute(name, value === true ? '' : value);
  }
  made.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return made;
}

const isNumber = (value) => typeof value === 'number' && Number.isFinite(value);
const listOf = (value) => (Array.isArray(value) ? value : []);

const superscripts = {
  '-': '⁻',
  0: '⁰',
  1: '¹',
  2: '²',
  3: '³',
  4: '⁴',
  5: '⁵',
  6: '⁶',
  7: '⁷',
  8: '⁸',
  9: '⁹'
};
const powerOfTen = (exponent) => '10' + [...String(exponent)].map((c) => superscripts[c]).join('');

/** Three significant digits, in powers of ten where plain digits would be long. */
function short(value, digits = 3) {
  if (!isNumber(value)) return '–';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size < 1e-3 || size >= 1e6) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split('e');
    return `${mantissa} × ${powerOfTen(Number(exponent))}`;
  }
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  return Number(value.toFixed(decimals)).toLocaleString('en', {
    minimumFractionDigits: size < 100 ? decimals : 0
  });
}

const whole = (value) => (isNumber(value) ? Math.round(value).toLocaleString('en') : '–');
const fixed = (digits) => (value) => (isNumber(value) ? value.toFixed(digits) : '–');
const millions = (value) => (isNumber(value) ? short(value / 1e6) : '–');
const mebibytes = (value) => (isNumber(value) ? whole(value / 2 ** 20) : '–');
const percent = (value) => (isNumber(value) ? `${short(100 * value, 2)} %` : '–');

/** Seconds in words: "85 ms", "12.3 s", "2 min 3 s", "1 h 40 min". */
function duration(seconds) {
  if (!isNumber(seconds)) return '–';
  if (seconds < 1e-3) return `${short(seconds * 1e6)} µs`;
  if (seconds < 1) return `${short(seconds * 1e3)} ms`;
  if (seconds < 60) return `${short(seconds)} s`;
  const minutes = Math.floor(Math.round(seconds) / 60);
  if (minutes < 60) return `${minutes} min ${Math.round(seconds) % 60} s`;
  return `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

const plural = (count, one, many = one + 's') => `${whole(count)} ${count === 1 ? one : many}`;

/** "2026-11-22T07:40:00Z" as "22 November 2026, 07:40 UTC"; anything else as it is. */
function date(text) {
  const when = new Date(text);
  if (!text || Number.isNaN(when.getTime())) return text || '–';
  const day =
      when.toLocaleDateString('en-GB', {day: 'numeric', month: 'long', year: 'numeric', timeZone: 'UTC'});
  return `${day}, ${when.toISOString().slice(11, 16)} UTC`;
}

/** Text for the plotting library, which reads a few HTML tags. */
const escaped = (text) => String(text).replace(/&/g, '&amp;').replace(/</g, '&lt;').replace(/>/g, '&gt;');

/** A colour of report.css as it is now, light or dark. */
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

// One colour, marker and dash for a family; markers are drawn here for the legend and by the plots.
const looks = [
  {symbol: 'circle', dash: 'solid', path: 'M6 1a5 5 0 1 0 .01 0Z', lines: ''},
  {symbol: 'square', dash: 'solid', path: 'M1.5 1.5h9v9h-9Z', lines: ''},
  {symbol: 'diamond', dash: 'dash', path: 'M6 0l6 6-6 6-6-6Z', lines: '6 4'},
  {symbol: 'triangle-up', dash: 'solid', path: 'M6 .5l5.5 10H.5Z', lines: ''},
  {symbol: 'triangle-down', dash: 'dash', path: 'M6 11.5l5.5-10H.5Z', lines: '6 4'},
  {symbol: 'cross', dash: 'dot', path: 'M4 0h4v4h4v4H8v4H4V8H0V4h4Z', lines: '2 3'},
  {
    symbol: 'star',
    dash: 'dashdot',
    path: 'M6 0l1.6 4H12L8.500 6.800 10 11.500 6 8.600 2 11.500 3.500 6.800 0 4h4.400Z',
    lines: '6 3 2 3'
  },
  {symbol: 'hexagon', dash: 'dot', path: 'M6 .5l5 2.750v5.500l-5 2.750-5-2.750v-5.500Z', lines: '2 3'},
];

/** Families by their id, in the study's order: name, short name for labels, look and colour name. */
function familiesOf(study) {
  const families = new Map();
  const add = (method) => {
    const index = families.size % looks.length;
    families.set(method.id, {
      ...method,
      name: method.name || method.id,
      short: method.short || method.id,
      // What labels in the plots begin with, so that who looks there finds it in the legend.
      label: [...new Set([method.short || method.id, method.name || method.id])].join(': '),
      ...looks[index],
      colourName: `series-${index + 1}`
    });
  };
  listOf(study.methods).forEach(add);
  // A cell of a method that the study does not introduce is shown all the same.
  const holders = [study.scenes, study.motion_length, study.point_count].flatMap(listOf);
  for (const cell of holders.flatMap((holder) => listOf(holder.cells))) {
    if (!families.has(cell.method)) add({id: cell.method});
  }
  return families;
}

/** The family's marker, on its line if `line`; decoration beside its name. */
function swatch(family, line) {
  const ns = 'http://www.w3.org/2000/svg';
  const svg = document.createElementNS(ns, 'svg');
  const shape = (tag, attributes) => {
    const made = document.createElementNS(ns, tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    svg.append(made);
  };
  svg.setAttribute('class', line ? 'swatch' : 'swatch mark');
  svg.setAttribute('viewBox', line ? '-9 0 30 12' : '0 0 12 12');
  svg.setAttribute('aria-hidden', 'true');
  const ink = `var(--${family.colourName})`;
  if (line)
    shape(
        'path',
        {d: 'M-9 6h30', style: `stroke: ${ink}`, 'stroke-width': 2, 'stroke-dasharray': family.lines});
  shape('path', {d: family.path, style: `fill: ${ink}`});
  return svg;
}

/** What a point or table row is called: "gpu 4", and in full "Six GPU passes, 4 sub-frames". */
const tag =
    (family,
     cell) => [family.short, cell.label ?? cell.setting].filter((part) => part || part === 0).join(' ');
const fullName = (family, cell) => [family.name, cell.setting].filter(Boolean).join(', ');

// What a point can be judged by. `least`: below it a logarithmic axis shows no difference worth its length.
const measures = [
  {
    id: 'rmse',
    name: 'RMSE',
    of: (cell) => cell.rmse,
    log: true,
    least: 1e-9,
    about: 'Root of the mean squared difference over all pixels and channels, linear RGB.'
  },
  {
    id: 'psnr_db',
    name: 'PSNR, dB',
    of: (cell) => cell.psnr_db ?? (cell.rmse === 0 ? Infinity : null),
    log: false,
    about: '20 log₁₀(1 / RMSE).'
  },
  {
    id: 'ssim',
    name: '1 − SSIM',
    of: (cell) => (isNumber(cell.ssim) ? 1 - cell.ssim : null),
    log: true,
    least: 1e-9,
    about: 'Structural similarity, as what is missing to 1.'
  },
  {
    id: 'flip',
    name: 'FLIP',
    of: (cell) => cell.flip,
    log: true,
    least: 1e-9,
    about: 'Mean perceived difference when the two pictures are flipped between, 0 to 1.'
  },
  {
    id: 'max_abs',
    name: 'Largest difference',
    of: (cell) => cell.max_abs,
    log: true,
    least: 1e-9,
    about: 'The worst channel of the worst pixel, linear.'
  },
];
