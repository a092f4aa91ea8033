// The player of a shared file. The function is written into the file as text: it uses nothing but its argument and the page around it.
// `clip`: of share.js. Times in s, forces in N, places in m.
export function playClip(clip) {
  const byId = (id) => document.getElementById(id), { states, images, shapes, body } = clip, last = states.at(-1).t;
  const figure = (value) => (Number.isFinite(value) ? String(Number(value.toPrecision(3))) : '-');
  const newest = (list, t) => list.reduce((best, item, i) => (item.t <= t + 1e-9 ? i : best), -1);
  let [now, playing, before, shown] = [0, false, 0, -1];
  byId('title').textContent = clip.title;
  byId('words').replaceChildren(...clip.words.map((text) => Object.assign(document.createElement('li'), { textContent: text })));
  byId('picture').hidden = !images.length;
  byId('field').hidden = !body;
  Object.assign(byId('place'), { min: 0, max: last, step: 0.01, value: 0 });

  // Force over time, with a band of one sigma; orange where it is not valid.
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
    for (const { t, name } of clip.events) {
      pen.fillStyle = '#7a4b00';
      pen.fillRect(x(t), top, 1, height - bottom - top);
      pen.textAlign = 'left';
      pen.fillText(name, Math.min(x(t) + 3, width - 70), top + 10);
    }
    pen.fillStyle = '#14202b';
    pen.fillRect(x(now) - 1, top, 2, height - bottom - top);
  }

  // The outline of the object, as computed, in the colours of its displacement.
  function drawField() {
    const i = newest(shapes, now);
    if (!body) return;
    const places = i < 0 ? body.rest : shapes[i].places,
      canvas = byId('field'),
      brush = canvas.getContext('2d'),
      [x0, y0, x1, y1] = body.box;
    const scale = Math.min((canvas.width - 40) / (x1 - x0), (canvas.height - 60) / (y1 - y0)),
      at = (node) => [20 + (places[2 * node] - x0) * scale, canvas.height - 40 - (places[2 * node + 1] - y0) * scale];
    brush.clearRect(0, 0, canvas.width, canvas.height);
    brush.lineWidth = 6;
    brush.lineCap = 'round';
    for (const [a, b] of body.lines) {
      const moved = Math.hypot(places[2 * a] - body.rest[2 * a], places[2 * a + 1] - body.rest[2 * a + 1]);
      const stops = [
          [68, 1, 84],
          [59, 82, 139],
          [33, 145, 140],
          [94, 201, 98],
          [253, 231, 37],
        ],
        part = Math.min(1, moved / clip.mostMoved) * 3.999,
        k = Math.floor(part);
      brush.strokeStyle = `rgb(${stops[k].map((low, c) => Math.round(low + (part - k) * (stops[k + 1][c] - low)))})`;
      brush.beginPath();
      brush.moveTo(...at(a));
      brush.lineTo(...at(b));
      brush.stroke();
    }
    brush.fillStyle = '#3c4a58';
    brush.font = '13px system-ui, sans-serif';
    brush.fillText(`displacement: dark 0, yellow ${figure(1e3 * clip.mostMoved)} mm`, 20, canvas.height - 12);
  }

  function show() {
    const state = states[Math.max(0, newest(states, now))], i = Math.max(0, newest(images, now));
    if (images.length && i !== shown) byId('picture').src = `data:image/jpeg;base64,${images[i].jpeg}`;
    shown = i;
    const force =
      state.force === null
        ? 'force unknown'
        : `${state.force.toFixed(3)} N ± ${figure(state.sigma)} N (${figure(state.force / 9.80665e-3)} g)`;
    byId('force').textContent = `${now.toFixed(2)} s: ${force}, ${state.validity.replaceAll('_', ' ')}`;
    byId('force').dataset.valid = state.validity === 'valid';
    byId('place').value = now;
    byId('place').setAttribute('aria-valuetext', byId('force').textContent);
    drawCurve();
    drawField();
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
