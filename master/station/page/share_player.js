// The player of a shared file. The function is written into the file as text, so it uses only its
// argument, the functions of field.js and colours.js, and the page around it. `clip`: the data of
// share.js. Times in s, forces in N.
import { drawField, visibleOf } from './field.js';
import { viridis } from './colours.js';

export function playClip(clip) {
  const byId = (id) => document.getElementById(id), { states, images, field } = clip, last = states.at(-1).t;
  const figure = (value) => (Number.isFinite(value) ? String(Number(value.toPrecision(3))) : '-');
  const newest = (list, t) => list.reduce((best, item, i) => (item.t <= t + 1e-9 ? i : best), -1);
  let [now, playing, before, decoded] = [0, false, 0, -1];
  byId('title').textContent = clip.title;
  byId('words').replaceChildren(...clip.words.map((text) => Object.assign(document.createElement('li'), { textContent: text })));
  const view = byId('view'), still = new Image(), bytesOf = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  view.hidden = !images.length && !field;
  byId('bar').hidden = !field;
  if (field) {
    const isSmall = field.full < 1e-4;
    byId('bar').lastElementChild.textContent = `${figure((isSmall ? 1e6 : 1e3) * field.full)} ${isSmall ? 'µm' : 'mm'}`;
    const tones = [0, 0.25, 0.5, 0.75, 1].map((part) => `rgb(${viridis(part).map(Math.round)})`);
    byId('bar').querySelector('i').style.background = `linear-gradient(to right, ${tones})`;
  }
  Object.assign(byId('place'), { min: 0, max: last, step: 0.01, value: 0 });

  // Draws force over time with a band of one sigma; orange where it is not valid.
  const curve = byId('curve'),
    pen = curve.getContext('2d'),
    [width, height] = [curve.width, curve.height],
    left = 56,
    bottom = 40,
    top = 14;
  const most = Math.max(0.01, ...states.map(({ force, sigma }) => (force ?? 0) + (sigma || 0)));
  const x = (t) => left + ((width - left - 12) * t) / (last || 1),
    y = (force) => height - bottom - ((height - bottom - top) * force) / most;
  const ticks = (end) => {
    const power = 10 ** Math.floor(Math.log10(end / 4)), step = power * [1, 2, 5, 10].find((part) => (end / 4) <= part * power);
    return Array.from({ length: Math.floor(end / step + 1e-9) + 1 }, (_, i) => i * step);
  };
  function drawCurve() {
    pen.clearRect(0, 0, width, height);
    pen.font = '13px system-ui, sans-serif';
    pen.textAlign = 'center';
    for (const t of ticks(last || 1)) {
      pen.fillStyle = '#d9dfe5';
      pen.fillRect(x(t), top, 1, height - bottom - top);
      pen.fillStyle = '#3c4a58';
      pen.fillText(figure(t), x(t), height - bottom + 16);
    }
    pen.fillText('time, s', (left + width) / 2, height - 6);
    pen.textAlign = 'right';
    for (const force of ticks(most)) {
      pen.fillStyle = '#d9dfe5';
      pen.fillRect(left, y(force), width - left - 12, 1);
      pen.fillStyle = '#3c4a58';
      pen.fillText(figure(force), left - 6, y(force) + 4);
    }
    pen.save();
    pen.translate(14, (height - bottom) / 2);
    pen.rotate(-Math.PI / 2);
    pen.textAlign = 'center';
    pen.fillText('force, N', 0, 0);
    pen.restore();
    for (const { t, force, sigma, validity } of states) {
      if (force === null) continue;
      pen.fillStyle = validity === 'valid' ? '#1668b855' : '#c2410c55';
      pen.fillRect(x(t) - 1, y(force + (sigma || 0)), 2, Math.max(1, y(Math.max(0, force - (sigma || 0))) - y(force + (sigma || 0))));
      pen.fillStyle = validity === 'valid' ? '#1668b8' : '#c2410c';
      pen.fillRect(x(t) - 1, y(force) - 1, 2.5, 2.5);
    }
    clip.events.forEach(({ t, name }, i) => {
      pen.fillStyle = '#7a4b00';
      pen.fillRect(x(t), top, 1, height - bottom - top);
      pen.textAlign = 'left';
      pen.fillText(name, Math.min(x(t) + 3, width - 70), top + 10 + 14 * (i % 3));
    });
    pen.fillStyle = '#14202b';
    pen.fillRect(x(now) - 1, top, 2, height - bottom - top);
  }

  // Draws the image with the displacement of the model over it.
  still.onload = () => drawView();
  function drawView() {
    const pen = view.getContext('2d'), i = field ? newest(field.frames, now) : -1;
    if (still.naturalWidth) view.height = Math.round((view.width * still.naturalHeight) / still.naturalWidth);
    pen.clearRect(0, 0, view.width, view.height);
    if (still.naturalWidth) pen.drawImage(still, 0, 0, view.width, view.height);
    if (i < 0) return;
    const frame = field.frames[i], places = new Uint16Array(bytesOf(frame.places).buffer);
    const offset = images.length ? 0 : (view.height - view.width) / 2, values = Array.from(bytesOf(frame.values), (value) => value / 255);
    const image = Array.from(places, (step, k) => ((2 * step) / 65535 - 0.5) * view.width + (k % 2 ? offset : 0));
    const layer = Object.assign(document.createElement('canvas'), { width: view.width, height: view.height });
    const seen = visibleOf(field.triangles, image, field.isPlanar);
    if (!images.length) {
      const brush = layer.getContext('2d');
      brush.fillStyle = `rgb(${viridis(0)})`;
      brush.beginPath();
      for (let k = 0; k < seen.length; ++k) brush[k % 3 ? 'lineTo' : 'moveTo'](image[2 * seen[k]], image[2 * seen[k] + 1]);
      brush.fill();
    }
    drawField(layer.getContext('2d'), seen, values, (node) => [image[2 * node], image[2 * node + 1]]);
    pen.globalAlpha = images.length ? 0.72 : 1;
    pen.drawImage(layer, 0, 0);
    pen.globalAlpha = 1;
    const isSeen = new Set(seen);
    pen.strokeStyle = '#f2f6fa';
    pen.beginPath();
    for (let k = 0; k < field.edges.length; k += 2) {
      const [a, b] = field.edges.slice(k, k + 2);
      if (!isSeen.has(a) || !isSeen.has(b)) continue;
      pen.moveTo(image[2 * a], image[2 * a + 1]);
      pen.lineTo(image[2 * b], image[2 * b + 1]);
    }
    pen.stroke();
  }

  function show() {
    const state = states[Math.max(0, newest(states, now))], i = Math.max(0, newest(images, now));
    if (images.length && i !== decoded) still.src = `data:image/jpeg;base64,${images[i].jpeg}`;
    else drawView();
    decoded = i;
    const force =
      state.force === null
        ? 'force unknown'
        : `${state.force.toFixed(3)} N ± ${figure(state.sigma)} N (${figure(state.force / 9.80665e-3)} g)`;
    byId('force').textContent = `${now.toFixed(2)} s: ${force}, ${state.validity.replaceAll('_', ' ')}`;
    byId('force').dataset.valid = state.validity === 'valid';
    byId('place').value = now;
    byId('place').setAttribute('aria-valuetext', byId('force').textContent);
    drawCurve();
  }
  function frame(at) {
    if (playing) {
      now = Math.min(last, now + (at - before) / 1e3);
      if (now >= last) pause(true);
      show();
    }
    before = at;
    requestAnimationFrame(frame);
  }
  function pause(isPaused) {
    playing = !isPaused;
    byId('play').textContent = playing ? 'Pause' : 'Play';
  }
  const go = (t) => {
    now = Math.min(last, Math.max(0, t));
    show();
  };
  byId('play').addEventListener('click', () => {
    if (now >= last) now = 0;
    pause(playing);
  });
  byId('place').addEventListener('input', () => go(byId('place').valueAsNumber));
  curve.addEventListener('click', ({ offsetX }) => go((((offsetX * width) / curve.clientWidth - left) * last) / (width - left - 12)));
  show();
  requestAnimationFrame(frame);
}
