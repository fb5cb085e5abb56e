// Labels placed so that none covers another.

const overlap = (a, b) => Math.max(0, Math.min(a.right, b.right) - Math.max(a.left, b.left)) *
    Math.max(0, Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top));

const boxAt = (x, y, width, height) =>
    ({left: x - width / 2, right: x + width / 2, top: y - height / 2, bottom: y + height / 2});

/** Whether the segment a-b passes through the box: Liang and Barsky's clipping. */
function crosses(a, b, box) {
  let from = 0, to = 1;
  const sides = [
    [a.x - b.x, a.x - box.left], [b.x - a.x, box.right - a.x], [a.y - b.y, a.y - box.top],
    [b.y - a.y, box.bottom - a.y]
  ];
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
      // The box touches a circle around the marker, so that a label beside its point is as near as one above
      // it.
      const x = label.x + cos * (label.width / 2 + 7 + reach);
      const y = label.y + sin * (label.height / 2 + 7 + reach);
      const box = boxAt(x, y, label.width, label.height);
      const outside = label.width * label.height - overlap(box, frame);
      let cost = 100 * outside + reach * 3 +
          (i % 4 === 0     ? 0 :
               i % 2 === 0 ? 1 :
                             2) +
          (i > 4 && i < 12 ? 1 : 0);
      for (const marker of obstacles.markers) cost += 20 * overlap(box, marker);
      for (const [a, b] of obstacles.lines) cost += crosses(a, b, box) ? 50 : 0;
      places.push({x, y, box, reach, cost});
    });
  }
  return places.sort((a, b) => a.cost - b.cost);
}

/**
 * Labels of lines that end at the same place: a column whose left edge is at `x`, in the order of their
 * points, each as near to its own as the others allow (least squares, by pooling neighbours that would
 * overlap).
 */
function placeInColumn(labels, x, frame) {
  const order = labels.map((label, i) => i).sort((a, b) => labels[a].y - labels[b].y);
  const height = Math.min(15, (frame.bottom - frame.top) / Math.max(1, labels.length));
  const pools = [];
  order.forEach((label, rank) => {
    pools.push({sum: labels[label].y - rank * height, count: 1});
    while (pools.length > 1 &&
           pools.at(-2).sum / pools.at(-2).count > pools.at(-1).sum / pools.at(-1).count) {
      const last = pools.pop();
      pools.at(-1).sum += last.sum;
      pools.at(-1).count += last.count;
    }
  });
  const starts = pools.flatMap(({sum, count}) => Array(count).fill(sum / count));
  const places = [];
  order.forEach((label, rank) => {
    const start = Math.min(
        Math.max(starts[rank], frame.top + height / 2), frame.bottom - (labels.length - 0.5) * height);
    const {width, y: from} = labels[label];
    const y = start + rank * height;
    places[label] = {
      x,
      y,
      box: boxAt(x + width / 2, y, width, height),
      reach: Math.abs(y - from) > 4 ? 20 : 0,
      anchor: 'left'
    };
  });
  return places;
}

/**
 * Where to put labels. `labels`: [{x, y, width, height}], the point and the text's size, px; `frame` the box
 * they must stay in; `obstacles`: {markers: boxes, lines: [[{x, y}, {x, y}]]}. Returns a place {x, y, box,
 * reach} each. Greedy, then each label once more against all others, until nothing moves.
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
