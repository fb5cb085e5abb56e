// One plot: series of points with markers, lines, error bars and labels.

const plots = [];
const labelFont = 11.5, columnGap = 26;  // px
const fontFamily = 'system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif';

const textWidth = (() => {
  const context = document.createElement('canvas').getContext('2d');
  return (text) => {
    context.font = `${labelFont}px ${fontFamily}`;
    return context.measureText(text).width + 4;
  };
})();

/**
 * A plot that follows its host's size and the page's colours.
 *
 * `describe` returns what is drawn, in data units:
 *   x, y      {title, log}
 *   series    [{id, family, hidden, points}], a point being {x, y, low, high, label, brief, hover, broken};
 *             low and high are ends of the error bar along `bars` ("x" or "y"); without a label it has none;
 *             `broken` ends the line: a failed result that has no place in the plot
 *   front     points of the Pareto front, or none
 *   untold    {y, text}: a line, and from it towards less error nothing can be told
 *   column    labels stand in a column at the right, beside the ends of their lines
 * A y of null, or not positive on a logarithmic axis, or infinite, stands at the axis's edge: no error at
 * all.
 */
class Plot {
  constructor(host, describe) {
    Object.assign(this, {host, describe, zoom: null, queued: false});
    plots.push(this);
    new ResizeObserver(() => this.queue()).observe(host);
  }

  queue() {
    if (this.queued) return;
    this.queued = true;
    requestAnimationFrame(() => {
      this.queued = false;
      this.draw();
    });
  }

  draw() {
    const width = this.host.clientWidth;
    if (width === 0 || typeof Plotly === 'undefined') return;
    const narrow = width < 600;
    const spec = this.describe();
    const shown = spec.series.filter((series) => !series.hidden);
    const axes = {x: rangeOf(spec, shown, 'x'), y: rangeOf(spec, shown, 'y')};
    // The library's buttons stand above the plot, where they hide nothing.
    const margin = {l: narrow ? 68 : 76, r: 14, t: 34, b: 52};
    const size = {width: width - margin.l - margin.r, height: this.host.clientHeight - margin.t - margin.b};
    if (spec.column) makeRoom(axes.x, shown, size, narrow);
    const view = this.zoom ?? {x: axes.x.range, y: axes.y.range};
    const layout = {
      autosize: false,
      width,
      height: this.host.clientHeight,
      margin,
      showlegend: false,
      hovermode: 'closest',
      dragmode: matchMedia('(pointer: coarse)').matches ? false : 'zoom',
      paper_bgcolor: colour('page'),
      plot_bgcolor: colour('page'),
      font: {family: fontFamily, size: 13, color: colour('text')},
      hoverlabel: {
        font: {family: fontFamily, size: 13},
        align: 'left',
        bgcolor: colour('panel'),
        bordercolor: colour('edge')
      },
      xaxis: axisLayout(spec.x, axes.x, view.x),
      yaxis: axisLayout(spec.y, axes.y, view.y),
      shapes: untoldShapes(spec, axes.y),
      annotations: labelsOf(spec, shown, axes, view, size, narrow),
    };
    const traces = [...frontTrace(spec, axes), ...shown.map((series) => trace(series, spec, axes))];
    // The library's own would return to the first measure's range.
    const whole = {name: 'Show all', icon: Plotly.Icons.home, click: () => this.change()};
    Plotly.react(this.host, traces, layout, {
      displaylogo: false,
      responsive: false,
      doubleClick: false,
      plotlyServerURL: '',
      // Named one by one: the library's own choice has a button that sends the data away.
      modeBarButtons: [['toImage'], ['zoom2d', 'pan2d'], ['zoomIn2d', 'zoomOut2d', whole]],
      toImageButtonOptions: {format: 'svg', filename: this.host.id || 'plot'},
    });
    this.listen();
  }

  /** Zooming keeps the labels readable by placing them anew. */
  listen() {
    if (this.listening) return;
    this.listening = true;
    this.host.on('plotly_relayout', (change) => {
      if (!Object.keys(change).some((key) => /axis\.(range|autorange)/.test(key))) return;
      const {xaxis, yaxis} = this.host.layout;
      this.zoom = {x: [...xaxis.range], y: [...yaxis.range]};
      this.queue();
    });
    this.host.on('plotly_doubleclick', () => this.change());
  }

  /** Other data: what was zoomed to means nothing there. */
  change() {
    this.zoom = null;
    this.queue();
  }
}

const textOf = (point, narrow) => (narrow ? point.brief : point.label);

/** The points of a series as the library wants them; a broken one is a gap in the line. */
function trace(series, spec, axes) {
  const points = series.points;
  const at = (key) =>
      points.map((point) => (point.broken ? null : placeOn(spec[key], axes[key], point[key])));
  const ink = colour(series.family.colourName);
  const made = {
    type: 'scatter',
    mode: points.length > 1 ? 'lines+markers' : 'markers',
    name: series.id,
    meta: {series: series.id},
    x: at('x'),
    y: at('y'),
    connectgaps: false,
    hoverinfo: 'text',
    hovertext: points.map((point) => point.hover ?? ''),
    line: {color: ink, width: 1.6, dash: series.family.dash},
    marker: {
      color: ink,
      symbol: series.family.symbol,
      size: series.family.symbol.startsWith('triangle') ? 12 : 10,
      line: {color: colour('page'), width: 1}
    },
  };
  if (spec.bars) {
    const axis = spec[spec.bars], middle = made[spec.bars];
    const ends = (key) => points.map(
        (point, i) => (middle[i] !== null && isNumber(point[key]) ? along(axis, point[key]) : middle[i]));
    made[`error_${spec.bars}`] = {
      type: 'data',
      symmetric: false,
      color: ink,
      thickness: 1.2,
      width: 3,
      array: ends('high').map((end, i) => Math.max(0, end - middle[i])),
      arrayminus: ends('low').map((end, i) => Math.max(0, middle[i] - end)),
    };
  }
  return made;
}

/** The best that can be had for a time: it stays until a costlier method does better, hence the steps. */
function frontTrace(spec, axes) {
  const front = listOf(spec.front);
  if (front.length === 0) return [];
  const sorted = [...front].sort((a, b) => a.x - b.x);
  const xs = sorted.map((point) => placeOn(spec.x, axes.x, point.x));
  const ys = sorted.map((point) => placeOn(spec.y, axes.y, point.y));
  return [{
    type: 'scatter',
    mode: 'lines',
    name: 'Pareto front',
    meta: {front: true},
    x: [...xs, axes.x.range[1]],
    y: [...ys, ys.at(-1)],
    hoverinfo: 'skip',
    line: {color: colour('edge'), width: 5, shape: 'hv'},
    opacity: 0.38,
  }];
}

function untoldShapes(spec, info) {
  if (!spec.untold) return [];
  const y = along(spec.y, spec.untold.y);
  const beyond = spec.y.better === 'high' ? info.range[1] + 9 : info.range[0] - 9;
  return [
    {
      type: 'rect',
      xref: 'paper',
      x0: 0,
      x1: 1,
      y0: y,
      y1: beyond,
      fillcolor: colour('untold'),
      line: {width: 0},
      layer: 'below'
    },
    {
      type: 'line',
      xref: 'paper',
      x0: 0,
      x1: 1,
      y0: y,
      y1: y,
      line: {color: colour('soft'), width: 1.5, dash: 'dash'},
      layer: 'below'
    },
  ];
}

/** Labels of all points in view, and of the line beyond which nothing can be told. */
function labelsOf(spec, shown, axes, view, size, narrow) {
  const pixel = (point) => ({
    x: (placeOn(spec.x, axes.x, point.x) - view.x[0]) / (view.x[1] - view.x[0]) * size.width,
    y: (view.y[1] - placeOn(spec.y, axes.y, point.y)) / (view.y[1] - view.y[0]) * size.height,
  });
  const frame = {left: 0, right: size.width, top: 0, bottom: size.height};
  const inside = ({x, y}) => x >= 0 && x <= size.width && y >= 0 && y <= size.height;
  const labels = [], obstacles = {markers: [], lines: []}, made = [];
  for (const series of shown) {
    let last = null;
    for (const point of series.points) {
      const at = point.broken ? null : pixel(point);
      if (at !== null && inside(at)) {
        obstacles.markers.push(boxAt(at.x, at.y, 13, 13));
        const text = textOf(point, narrow);
        if (point.label)
          labels.push({...at, text, width: textWidth(text), height: 15, family: series.family});
      }
      if (at !== null && last !== null) obstacles.lines.push([last, at]);
      if (at !== null && spec.bars && isNumber(point.low) && isNumber(point.high))
        obstacles.lines.push(
            [pixel({...point, [spec.bars]: point.low}), pixel({...point, [spec.bars]: point.high})]);
      last = at;
    }
  }
  const front = listOf(spec.front).map(pixel).sort((a, b) => a.x - b.x);
  front.forEach((at, i) => {
    const next = front[i + 1] ?? {x: size.width, y: at.y};
    obstacles.lines.push([at, {x: next.x, y: at.y}], [{x: next.x, y: at.y}, next]);
  });
  if (spec.untold) {
    const y = along(spec.y, spec.untold.y), top = spec.y.better === 'high';
    const line = pixel({x: null, y: spec.untold.y}).y;
    const text = narrow ? spec.untold.brief : spec.untold.text;
    made.push({
      xref: 'paper',
      x: 1,
      xanchor: 'right',
      y,
      yanchor: top ? 'bottom' : 'top',
      text: escaped(text),
      showarrow: false,
      font: {size: 11.5, color: colour('soft')},
      borderpad: 2,
      name: 'untold'
    });
    const width = textWidth(text) + 8;
    obstacles.markers.push(boxAt(size.width - width / 2, line + (top ? -10 : 10), width, 20));
    obstacles.lines.push([{x: 0, y: line}, {x: size.width, y: line}]);
  }
  const last = Math.max(...labels.map(({x}) => x));
  const inColumn = (label) => spec.column && label.x > last - 1;
  const column = placeInColumn(labels.filter(inColumn), last + columnGap, frame);
  obstacles.markers.push(...column.map(({box}) => box));
  const free = placeLabels(labels.filter((label) => !inColumn(label)), frame, obstacles);
  labels.map((label) => (inColumn(label) ? column : free).shift()).forEach((place, i) => {
    const {x, y, text, family} = labels[i];
    const ink = colour(family.colourName);
    made.push({
      x: view.x[0] + x / size.width * (view.x[1] - view.x[0]),
      y: view.y[1] - y / size.height * (view.y[1] - view.y[0]),
      ax: place.x - x,
      ay: place.y - y,
      text: escaped(text),
      font: {size: labelFont, color: ink},
      showarrow: true,
      arrowhead: 0,
      arrowwidth: 0.8,
      arrowcolor: place.reach > 8 ? ink : 'rgba(0,0,0,0)',
      standoff: 5,
      borderpad: 0,
      xanchor: place.anchor ?? 'auto',
      bgcolor: colour('veil'),
      name: 'label',
    });
  });
  return made;
}

matchMedia('(prefers-color-scheme: dark)')
    .addEventListener('change', () => plots.forEach((plot) => plot.queue()));
