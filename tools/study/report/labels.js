// Ticks of logarithmic axes, and labels placed so that none covers another.

// Axes run in log₁₀ units where `log` is set; the plotting library sees linear ones.
const along = (axis, value) => (axis.log ? Math.log10(value) : value);

function tickText(value) {
  const exponent = Math.floor(Math.log10(value) + 1e-9);
  const mantissa = Math.round(value / 10 ** exponent);
  if (exponent >= -3 && exponent < 7) return (mantissa * 10 ** exponent).toLocaleString("en", {minimumFractionDigits: Math.max(0, -exponent)});
  return mantissa === 1 ? powerOfTen(exponent) : `${mantissa}×${powerOfTen(exponent)}`;
}

/** Ticks of a logarithmic axis over [low, high] (log₁₀): decades, or 1-2-5 over few of them, in data units. */
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

const overlap = (a, b) => Math.max(0, Math.min(a.right, b.right) - Math.max(a.left, b.left)) *
                          Math.max(0, Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top));

const boxAt = (x, y, width, height) =>
  ({left: x - width / 2, right: x + width / 2, top: y - height / 2, bottom: y + height / 2});

/** Whether the segment a-b passes through the box: Liang and Barsky's clipping. */
function crosses(a, b, box) {
  let from = 0, to = 1;
  const sides = [[a.x - b.x, a.x - box.left], [b.x - a.x, box.right - a.x],
                 [a.y - b.y, a.y - box.top], [b.y - a.y, box.bottom - a.y]];
  for (const [p, q] of sides) {
    if (p === 0 && q < 0) return false;
    if (p < 0) from = Math.max(from, q / p);
    if (p > 0) to = Math.min(to, q / p);
  }
  return from < to;
}

const reaches = [0, 5, 12, 22, 36, 54, 78, 108, 144, 190];  // px from marker to label
const directions = Array.from({length: 16}, (_, i) => [Math.cos(i * Math.PI / 8), Math.sin(i * Math.PI / 8)]);

/** The places a label may take around its point, with what each costs by itself. */
function placesOf(label, frame, obstacles) {
  const places = [];
  for (const reach of reaches) {
    directions.forEach(([cos, sin], i) => {
      // The box touches a circle around the marker, so that a label beside its point is as near as one above it.
      const x = label.x + cos * (label.width / 2 + 7 + reach);
      const y = label.y + sin * (label.height / 2 + 7 + reach);
      const box = boxAt(x, y, label.width, label.height);
      const outside = label.width * label.height - overlap(box, frame);
      let cost = 100 * outside + reach * 3 + (i % 4 === 0 ? 0 : i % 2 === 0 ? 1 : 2) + (i > 4 && i < 12 ? 1 : 0);
      for (const marker of obstacles.markers) cost += 20 * overlap(box, marker);
      for (const [a, b] of obstacles.lines) cost += crosses(a, b, box) ? 50 : 0;
      places.push({x, y, box, reach, cost});
    });
  }
  return places.sort((a, b) => a.cost - b.cost);
}

/**
 * Where to put labels. `labels`: [{x, y, width, height}], the point and the text's size, px; `frame` the box they
 * must stay in; `obstacles`: {markers: boxes, lines: [[{x, y}, {x, y}]]}. Returns a place {x, y, box, reach} each.
 * Greedy, then each label once more against all others, until nothing moves.
 */
function placeLabels(labels, frame, obstacles) {
  const all = labels.map((label) => placesOf(label, frame, obstacles));
  const taken = labels.map(() => null);
  const costOf = (place, i) => {
    let cost = place.cost;
    taken.forEach((other, j) => {
      if (other === null || j === i) return;
      cost += 60 * overlap(place.box, other.box);
      // A leader through another label reads as that label's own.
      if (place.reach > 8 && crosses(labels[i], place, other.box)) cost += 60;
      if (other.reach > 8 && crosses(labels[j], other, place.box)) cost += 60;
    });
    return cost;
  };
  for (let round = 0, moved = true; round < 6 && moved; ++round) {
    moved = false;
    for (let i = 0; i < labels.length; ++i) {
      let best = null, least = Infinity;
      for (const place of all[i]) {
        if (place.cost >= least) break;  // sorted: nothing cheaper can follow
        const cost = costOf(place, i);
        if (cost < least) [best, least] = [place, cost];
      }
      if (best !== taken[i]) {
        taken[i] = best;
        moved = true;
      }
    }
  }
  return taken;
}
