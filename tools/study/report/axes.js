// Axes: ranges, ticks, and where a value stands that has no place on a logarithm.

// Axes run in log₁₀ units where `log` is set; the plotting library sees linear ones.
const along = (axis, value) => (axis.log ? Math.log10(value) : value);

function tickText(value) {
  const exponent = Math.floor(Math.log10(value) + 1e-9);
  const mantissa = Math.round(value / 10 ** exponent);
  if (exponent >= -3 && exponent < 7)
    return (mantissa * 10 ** exponent).toLocaleString('en', {minimumFractionDigits: Math.max(0, -exponent)});
  return mantissa === 1 ? powerOfTen(exponent) : `${mantissa}×${powerOfTen(exponent)}`;
}

/**
 * Ticks of a logarithmic axis over [low, high] (log₁₀): decades, or 1-2-5 over few of them, in data units.
 */
function logTicks(low, high) {
  const ticks = {values: [], texts: [], minor: []};
  const span = high - low;
  const inside = (value) => Math.log10(value) >= low - 1e-9 && Math.log10(value) <= high + 1e-9;
  const step = Math.max(1, Math.ceil(span / 8));
  const labelled = span > 2.5 ? [1] : span > 1 ? [1, 2, 5] : [1, 2, 3, 5, 7];
  for (let exponent = Math.floor(low); exponent <= Math.ceil(high); ++exponent) {
    for (let mantissa = 1; mantissa < 10; ++mantissa) {
      // From text, so that 3·10⁻⁵ is that number and not its neighbour.
      const value = Number(`${mantissa}e${exponent}`);
      if (!inside(value)) continue;
      if (labelled.includes(mantissa) && exponent % step === 0) {
        ticks.values.push(Math.log10(value));
        ticks.texts.push(tickText(value));
      } else if (step === 1) {
        ticks.minor.push(Math.log10(value));
      }
    }
  }
  return ticks;
}

/** A value's place along an axis, its edge if it has none: no error at all is as far as "better" goes. */
function placeOn(axis, info, value) {
  if (axis.log ? isNumber(value) && value >= (axis.least ?? Number.MIN_VALUE) : isNumber(value))
    return along(axis, value);
  return info.edge;
}

/**
 * The range that shows all points, in axis units, with room for labels, and where values without a place go.
 */
function rangeOf(spec, shown, key) {
  const axis = spec[key];
  const values = shown.flatMap((series) => series.points)
                     .filter((point) => !point.broken)
                     .flatMap((point) => [point[key], ...(spec.bars === key ? [point.low, point.high] : [])]);
  if (key === 'y' && spec.untold) values.push(spec.untold.y);
  const placed = values.map((value) => placeOn(axis, {edge: null}, value)).filter(isNumber);
  const [low, high] = placed.length > 0 ? [Math.min(...placed), Math.max(...placed)] : [0, 1];
  const span = Math.max(high - low, axis.log ? 0.5 : 1);
  const missing = shown.some(
      (series) =>
          series.points.some((point) => !point.broken && placeOn(axis, {edge: null}, point[key]) === null));
  // The edge is beyond everything that has a place.
  const better = axis.better === 'high' ? high + 0.12 * span : low - 0.12 * span;
  const ends = missing ? [Math.min(low, better), Math.max(high, better)] : [low, high];
  const pad = 0.09 * Math.max(ends[1] - ends[0], axis.log ? 0.5 : 1);
  return {edge: better, missing, low, high, range: [ends[0] - pad, ends[1] + pad]};
}

function axisLayout(axis, info, view) {
  const made = {
    title: {text: axis.title, standoff: 8},
    range: [...view],
    zeroline: false,
    gridcolor: colour('line'),
    linecolor: colour('edge'),
    showline: true,
    ticks: 'outside',
    tickcolor: colour('edge'),
    ticklen: 5,
    automargin: false,
  };
  if (!axis.log && !info.missing) return made;
  const ticks = axis.log ? logTicks(...view) : linearTicks(...view);
  // Beyond the last value with a place ticks would be read as a scale that goes on to the edge.
  const gap = 0.4 * Math.abs(info.edge - (axis.better === 'high' ? info.high : info.low));
  const scaled = (value) =>
      !info.missing || (axis.better === 'high' ? value < info.edge - gap : value > info.edge + gap);
  const kept =
      ticks.values.map((value, i) => ({value, text: ticks.texts[i]})).filter(({value}) => scaled(value));
  if (info.missing) kept.push({value: info.edge, text: axis.none ?? '0'});
  Object.assign(
      made,
      {tickmode: 'array', tickvals: kept.map(({value}) => value), ticktext: kept.map(({text}) => text)});
  if (axis.log) {
    made.minor = {
      tickmode: 'array',
      tickvals: ticks.minor.filter(scaled),
      ticks: 'outside',
      ticklen: 3,
      tickcolor: colour('edge'),
      showgrid: false
    };
  }
  return made;
}

function linearTicks(low, high) {
  const rough = (high - low) / 7, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((candidate) => candidate >= rough);
  const ticks = {values: [], texts: []};
  for (let i = Math.ceil(low / step); i * step <= high; ++i) {
    ticks.values.push(i * step);
    ticks.texts.push(String(Number((i * step).toPrecision(12))));
  }
  return ticks;
}

/** Widens an axis so that a column of labels fits between the points and the plot's right side. */
function makeRoom(info, shown, size, narrow) {
  const texts = shown.flatMap((series) => series.points)
                    .filter((point) => point.label)
                    .map((point) => textOf(point, narrow));
  const share = Math.min(0.6, (Math.max(0, ...texts.map(textWidth)) + columnGap + 6) / size.width);
  info.range[1] = info.range[0] + (info.high - info.range[0]) / (1 - share);
}
