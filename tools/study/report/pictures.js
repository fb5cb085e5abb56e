// Two pictures compared at a split that moves, and what differs from the reference.

/** The images of the page, decoded when they are shown. */
const imageText = new Map(
    [...document.querySelectorAll('script[data-image]')].map((holder) => [holder.dataset.image, holder]));
const hasImage = (path) => typeof path === 'string' && imageText.has(path);
const imageSource = (path) => `data:image/png;base64,${imageText.get(path).textContent}`;

/** What can be compared: the reference, then each result that has a picture. */
function picturesOf(scene, families) {
  const pictures = [];
  const {reference} = scene;
  if (hasImage(reference?.image)) {
    const name = isNumber(reference.samples) ? `Reference, ${whole(reference.samples)} stills` : 'Reference';
    const own = isNumber(reference.psnr_db) ? `, its own error ${fixed(1)(reference.psnr_db)} dB` : '';
    pictures.push({
      id: 'reference',
      name,
      image: reference.image,
      about: `${name}: ${duration(reference.seconds)}${own}`
    });
  }
  for (const cell of listOf(scene.cells)
           .filter((candidate) => isDone(candidate) && hasImage(candidate.image))) {
    const name = fullName(families.get(cell.method), cell);
    const psnr = measures[1].of(cell);
    pictures.push({
      id: cell.id,
      name,
      image: cell.image,
      cell,
      about: `${name}: ${duration(median(cell))}, PSNR ${psnr === Infinity ? '∞' : fixed(1)(psnr)} dB`
    });
  }
  return pictures;
}

/** Small pictures are shown at a whole multiple of their size, their pixels as squares. */
function pictureBox(scene) {
  if (!(scene.width <= 540)) return {};
  return {class: 'pixels', style: `max-width: ${scene.width * Math.floor(540 / scene.width)}px`};
}

/** The slider, which moves with the range below it and with a pointer on the picture. */
function splitView(scene) {
  const left = element('img', {class: 'left'}), right = element('img', {class: 'right'});
  const tags = {
    left: element('span', {class: 'tag of-left', 'aria-hidden': 'true'}),
    right: element('span', {class: 'tag of-right', 'aria-hidden': 'true'})
  };
  const stack = element(
      'div', {class: 'stack'}, right, left, element('span', {class: 'divider'}), tags.left, tags.right);
  const range = element('input', {
    type: 'range',
    min: 0,
    max: 100,
    step: 'any',
    value: 50,
    'aria-label': 'Split between the left and the right picture'
  });
  const show = () => {
    stack.style.setProperty('--split', `${range.value}%`);
    range.setAttribute('aria-valuetext', `${Math.round(range.value)} % left picture`);
  };
  range.addEventListener('input', show);
  // A step that any value may take moves by nothing useful on its own.
  range.addEventListener('keydown', (event) => {
    const move = {
      ArrowLeft: -2,
      ArrowDown: -2,
      ArrowRight: 2,
      ArrowUp: 2,
      PageDown: -10,
      PageUp: 10,
      Home: -100,
      End: 100
    }[event.key];
    if (move === undefined) return;
    event.preventDefault();
    range.value = Number(range.value) + move;
    show();
  });
  const follow = (event) => {
    const box = stack.getBoundingClientRect();
    range.value = 100 * (event.clientX - box.left) / box.width;
    show();
  };
  stack.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    event.preventDefault();
    stack.setPointerCapture(event.pointerId);
    follow(event);
  });
  stack.addEventListener('pointermove', (event) => stack.hasPointerCapture(event.pointerId) && follow(event));
  show();
  const put = (side, picture) => {
    const image = side === 'left' ? left : right;
    Object.assign(
        image, {src: imageSource(picture.image), alt: `${scene.title ?? scene.id}: ${picture.name}`});
    // A size before it is decoded, so that nothing below jumps.
    if (isNumber(scene.width) && isNumber(scene.height))
      Object.assign(image, {width: scene.width, height: scene.height});
    tags[side].textContent = picture.name;
  };
  return {node: element('div', pictureBox(scene), stack, range), put};
}

/** What the colours of difference images mean. */
function colourBar(scale) {
  if (!scale || listOf(scale.colors).length < 2) return null;
  const steps = scale.log ? Math.max(1, Math.round(Math.log10(scale.high / scale.low))) : 4;
  const ticks = Array.from({length: steps + 1}, (_, i) => {
    const part = i / steps;
    return short(
        scale.log ? scale.low * (scale.high / scale.low) ** part : scale.low + part * (scale.high - scale.low),
        2);
  });
  ticks[steps] += ' and more';
  if (scale.log) ticks[0] += ' and less';
  return [
    element('div', {
      class: 'colour-bar',
      role: 'img',
      'aria-label': `Colour scale from ${scale.low} to ${scale.high}`,
      style: `background: linear-gradient(to right, ${scale.colors.join(', ')})`
    }),
    element('div', {class: 'colour-ticks'}, ticks.map((text) => element('span', {}, text))),
    element('p', {class: 'soft small'}, scale.unit ?? '')
  ];
}

/** The difference image of a picture, its worst place marked. */
function differenceView(scene, scale) {
  const image = element('img', {class: 'difference-image'}), worst = element('span', {class: 'worst'});
  const frame = element('div', {class: 'difference'}, image, worst);
  const caption = element('p', {class: 'small'});
  const node = element('div', pictureBox(scene), frame, colourBar(scale), caption);
  const put = (picture) => {
    const {cell} = picture;
    const shown = cell !== undefined && hasImage(cell.difference);
    frame.hidden = !shown;
    const at = listOf(cell?.max_abs_at);
    worst.hidden = !shown || at.length !== 2 || !(cell.max_abs > 0);
    if (!shown) {
      caption.textContent = cell === undefined ?
          'The reference does not differ from itself; choose another picture on the right.' :
          'There is no difference image of this result.';
      return;
    }
    Object.assign(
        image, {src: imageSource(cell.difference), alt: `Difference of ${picture.name} from the reference`});
    if (isNumber(scene.width) && isNumber(scene.height))
      Object.assign(image, {width: scene.width, height: scene.height});
    worst.style.left = `${100 * (at[0] + 0.5) / scene.width}%`;
    worst.style.top = `${100 * (at[1] + 0.5) / scene.height}%`;
    const place = worst.hidden ? '' : `, at (${at[0]}, ${at[1]}), ringed`;
    caption.textContent =
        `${picture.name} minus the reference. Largest difference ${short(cell.max_abs)}${place}.`;
  };
  return {node, put};
}

/** The comparison of a scene, or nothing without two pictures. */
function pictureSection(scene, families, scale) {
  const pictures = picturesOf(scene, families);
  if (pictures.length < 2) return null;
  const split = splitView(scene), difference = differenceView(scene, scale);
  const about = element('p', {class: 'small soft', 'aria-live': 'polite'});
  const rated = pictures.filter(({cell}) => isNumber(cell?.rmse)).sort((a, b) => b.cell.rmse - a.cell.rmse);
  // To begin with, the most that there is to see.
  const chosen = {left: pictures[0], right: rated[0] ?? pictures[1]};
  const put = (side, id) => {
    chosen[side] = pictures.find((picture) => picture.id === id);
    split.put(side, chosen[side]);
    if (side === 'right') difference.put(chosen.right);
    about.textContent = `Left, ${chosen.left.about}. Right, ${chosen.right.about}.`;
  };
  const options = pictures.map(({id, name}) => [id, name]);
  const controls = element(
      'div', {class: 'controls'}, chooser('Left', options, chosen.left.id, (id) => put('left', id)),
      chooser('Right', options, chosen.right.id, (id) => put('right', id)));
  put('left', chosen.left.id);
  put('right', chosen.right.id);
  return element(
      'figure', {class: 'comparison'}, controls,
      element('div', {class: 'pictures'}, split.node, difference.node), about);
}
