// Sets points in the camera's image by mouse, touch and keyboard, with zoom and a magnifier.
// Positions are in the image [px].

// Radius within which a point can be grabbed [px on the screen].
const GRAB_PX = { mouse: 9, pen: 12, touch: 24 };
const STILL_PX = 4;  // a press that moves less is a click [px on the screen]
const STEP_PX = 10;  // step of an arrow key; with Shift it is 1 [px]
const MAX_ZOOM = 12, ZOOM_STEP = 1.3;
const LENS_ZOOM = 4;  // screen pixels per pixel of the image
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const NUDGE = 'Arrow keys move the cross, with Shift by one pixel. Enter sets a point.';

// `acts`: isOpen(): whether points may be set; points(): of this step, which can be moved; takesBox(); click(at); move(i, at);
// box(from, to); preview({i, at} or {box}), null: nothing is dragged; tell(words).
export class Pointing {
  constructor(canvas, lens, acts) {
    Object.assign(this, {
      canvas,
      lens,
      acts,
      view: { zoom: 1, x: 0, y: 0 },
      pointers: new Map(),
      cross: null,
      picked: null,
      corner: null,
      held: null,
    });
    const on = (name, act) => canvas.addEventListener(name, (event) => act.call(this, event));
    on('pointerdown', this.down);
    on('pointermove', this.moves);
    on('pointerup', this.up);
    on('pointercancel', this.cancel);
    on('pointerleave', () => this.hideLens());
    on('keydown', this.key);
    on('focus', () => canvas.matches(':focus-visible') && this.showCross());
    on('blur', this.leave);
    canvas.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
    // Line widths depend on the size on the screen.
    new ResizeObserver(() => acts.redraw()).observe(canvas.parentElement);
  }
  get box() {
    return this.canvas.getBoundingClientRect();
  }
  // Screen pixels per pixel of the image.
  get scale() {
    const { box, canvas } = this;
    return Math.min(box.width / canvas.width, box.height / canvas.height) || 1;
  }
  place({ clientX, clientY }) {
    const { box, scale, canvas } = this;
    return [
      (clientX - box.x - (box.width - scale * canvas.width) / 2) / scale - 0.5,
      (clientY - box.y - (box.height - scale * canvas.height) / 2) / scale - 0.5,
    ];
  }
  isInside([u, v]) {
    return u >= -0.5 && v >= -0.5 && u < this.canvas.width && v < this.canvas.height;
  }
  // Returns the number of the point within reach; -1: none.
  pointAt(at, kind) {
    const far = this.acts.points().map((point) => Math.hypot(point[0] - at[0], point[1] - at[1]) * this.scale), near = Math.min(...far);
    return near <= (GRAB_PX[kind] || GRAB_PX.mouse) ? far.indexOf(near) : -1;
  }
  // Resets zoom and points for a new image or another step.
  reset() {
    Object.assign(this, { picked: null, corner: null, held: null });
    this.acts.preview(null);
  }

  down(event) {
    const at = this.place(event);
    this.pointers.set(event.pointerId, event);
    if (this.pointers.size === 2) return this.beginPinch();
    if (event.button !== 0 || this.pointers.size > 1 || !this.acts.isOpen() || !this.isInside(at)) return;
    this.cross = null;
    this.canvas.setPointerCapture(event.pointerId);
    this.held = { from: at, at, start: event, point: this.pointAt(at, event.pointerType), isMoved: false };
  }
  moves(event) {
    if (this.pointers.has(event.pointerId)) this.pointers.set(event.pointerId, event);
    if (this.pinch) return this.pinchOn();
    const at = this.place(event), { held } = this;
    if (this.acts.isOpen()) this.showLens(held?.point >= 0 && held.isMoved ? this.shifted(held, at) : at);
    if (!held) return;
    held.isMoved ||= Math.hypot(event.clientX - held.start.clientX, event.clientY - held.start.clientY) > STILL_PX;
    if (!held.isMoved) return;
    if (held.point >= 0) this.acts.preview({ i: held.point, at: this.shifted(held, at) });
    else if (this.acts.takesBox()) this.acts.preview({ box: [held.from, at] });
    else if (this.view.zoom > 1)
      this.pan(event.clientX - (held.last ?? held.start).clientX, event.clientY - (held.last ?? held.start).clientY);
    held.last = event;
  }
  // A point that is dragged keeps its distance from the finger.
  shifted({ from, point }, at) {
    const [u, v] = this.acts.points()[point];
    return [u + at[0] - from[0], v + at[1] - from[1]];
  }
  up(event) {
    this.pointers.delete(event.pointerId);
    if (this.pointers.size === 0) this.pinch = null;
    const { held } = this, at = this.place(event);
    this.held = null;
    if (event.pointerType !== 'mouse') this.hideLens();
    if (!held) return;
    const point = held.point >= 0 && held.isMoved ? this.shifted(held, at) : null;
    this.acts.preview(null);
    if (!held.isMoved) this.acts.click(held.from);
    else if (point) this.acts.move(held.point, point);
    else if (this.acts.takesBox()) this.acts.box(held.from, at);
  }
  cancel(event) {
    this.pointers.delete(event.pointerId);
    if (this.pointers.size === 0) this.pinch = null;
    this.held = null;
    this.acts.preview(null);
    this.hideLens();
  }

  // Zooms around the cursor or the middle between two fingers.
  zoomAt(clientX, clientY, factor) {
    const host = this.canvas.parentElement.getBoundingClientRect(),
      { zoom, x, y } = this.view,
      next = Math.min(MAX_ZOOM, Math.max(1, zoom * factor)),
      part = next / zoom;
    const [cx, cy] = [clientX - host.x, clientY - host.y];
    this.show({ zoom: next, x: cx - part * (cx - x), y: cy - part * (cy - y) });
  }
  pan(dx, dy) {
    this.show({ ...this.view, x: this.view.x + dx, y: this.view.y + dy });
  }
  // Limits the shift so that the image fills its area.
  show({ zoom, x, y }) {
    const host = this.canvas.parentElement.getBoundingClientRect(), most = (size) => (1 - zoom) * size;
    this.view = { zoom, x: Math.min(0, Math.max(most(host.width), x)), y: Math.min(0, Math.max(most(host.height), y)) };
    this.canvas.style.transform = zoom === 1 ? '' : `translate(${this.view.x}px, ${this.view.y}px) scale(${zoom})`;
    this.acts.redraw();
  }
  zoomMiddle(factor) {
    const host = this.canvas.parentElement.getBoundingClientRect(), at = this.cross && this.onScreen(this.cross);
    this.zoomAt(at?.[0] ?? host.x + host.width / 2, at?.[1] ?? host.y + host.height / 2, factor);
  }
  onScreen([u, v]) {
    const { box, scale, canvas } = this;
    return [
      box.x + (box.width - scale * canvas.width) / 2 + scale * (u + 0.5),
      box.y + (box.height - scale * canvas.height) / 2 + scale * (v + 0.5),
    ];
  }
  wheel(event) {
    event.preventDefault();
    this.zoomAt(event.clientX, event.clientY, event.deltaY < 0 ? ZOOM_STEP : 1 / ZOOM_STEP);
  }
  beginPinch() {
    this.held = null;
    this.acts.preview(null);
    this.hideLens();
    this.pinch = this.fingers();
  }
  fingers() {
    const [a, b] = [...this.pointers.values()];
    return {
      x: (a.clientX + b.clientX) / 2,
      y: (a.clientY + b.clientY) / 2,
      apart: Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY),
    };
  }
  pinchOn() {
    if (this.pointers.size < 2) return;
    const now = this.fingers(), { x, y, apart } = this.pinch;
    this.pan(now.x - x, now.y - y);
    this.zoomAt(now.x, now.y, now.apart / Math.max(1, apart));
    this.pinch = now;
  }

  // Shows the cross that the arrow keys move.
  showCross() {
    if (!this.acts.isOpen()) return;
    this.cross ??= [Math.round(this.canvas.width / 2), Math.round(this.canvas.height / 2)];
    this.showLens(this.cross);
    this.acts.tell(NUDGE);
    this.acts.redraw();
  }
  leave() {
    Object.assign(this, { cross: null, picked: null, corner: null });
    this.acts.preview(null);
    this.hideLens();
    this.acts.redraw();
  }
  key(event) {
    const { key } = event;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const zoom = { '+': ZOOM_STEP, '=': ZOOM_STEP, '-': 1 / ZOOM_STEP, 0: 0 }[key];
    if (zoom !== undefined) this.zoomMiddle(zoom);
    else if (!this.acts.isOpen() || !(ARROWS[key] || /^(Enter|PageUp|PageDown)$/.test(key))) return;
    else if (ARROWS[key]) this.nudge(ARROWS[key], event.shiftKey ? 1 : STEP_PX);
    else if (key === 'Enter') this.set();
    else this.pick(key === 'PageDown' ? 1 : -1);
    event.preventDefault();
    event.stopPropagation();
  }
  nudge([du, dv], step) {
    this.showCross();
    const { width, height } = this.canvas;
    this.cross = [
      Math.min(width - 1, Math.max(0, this.cross[0] + step * du)),
      Math.min(height - 1, Math.max(0, this.cross[1] + step * dv)),
    ];
    if (this.picked !== null) this.acts.preview({ i: this.picked, at: this.cross });
    else if (this.corner) this.acts.preview({ box: [this.corner, this.cross] });
    this.follow();
  }
  // Keeps the cross in view and reports its position.
  follow() {
    const host = this.canvas.parentElement.getBoundingClientRect(), [x, y] = this.onScreen(this.cross);
    if (this.view.zoom > 1)
      this.pan(
        Math.max(0, host.x + 20 - x) - Math.max(0, x - host.right + 20),
        Math.max(0, host.y + 20 - y) - Math.max(0, y - host.bottom + 20),
      );
    this.showLens(this.cross);
    this.acts.tell(
      `Cross at ${Math.round(this.cross[0])}, ${Math.round(this.cross[1])} ` +
      `px${this.picked === null ? '' : `, point ${this.picked + 1} moves: Enter sets it down`}`,
    );
    this.acts.redraw();
  }
  set() {
    if (!this.cross) return this.showCross();
    const { cross, picked, corner } = this, at = [...cross];
    this.acts.preview(null);
    Object.assign(this, { picked: null, corner: null });
    if (picked !== null) this.acts.move(picked, at);
    else if (corner) this.acts.box(corner, at);
    else if (this.acts.takesBox()) this.beginBox(at);
    else this.acts.click(at);
    this.showLens(cross);
    if (!this.corner) this.acts.tell(`${this.acts.points().length} points are set.`);
  }
  beginBox(at) {
    this.corner = at;
    this.acts.preview({ box: [at, at] });
    this.acts.tell('One corner of the box is set. Move to the opposite corner, and press Enter.');
  }
  // Selects the next point.
  pick(step) {
    const points = this.acts.points();
    if (!points.length) return;
    this.acts.preview(null);
    this.picked = this.picked === null ? (step > 0 ? 0 : points.length - 1) : (this.picked + step + points.length) % points.length;
    this.cross = [...points[this.picked]];
    this.follow();
  }

  // Shows the magnifier in the corner of the image that is farther from `at`.
  showLens(at) {
    const { lens, canvas } = this,
      pen = lens.getContext('2d'),
      wide = lens.width / LENS_ZOOM,
      [x] = this.onScreen(at),
      host = canvas.parentElement.getBoundingClientRect();
    lens.hidden = !this.isInside(at);
    if (lens.hidden) return;
    this.lensAt = at;
    lens.classList.toggle('right', x < host.x + host.width / 2);
    pen.imageSmoothingEnabled = false;
    pen.fillStyle = '#000';
    pen.fillRect(0, 0, lens.width, lens.height);
    pen.drawImage(canvas, at[0] + 0.5 - wide / 2, at[1] + 0.5 - wide / 2, wide, wide, 0, 0, lens.width, lens.height);
    const middle = lens.width / 2;
    for (const [colour, width] of [['#000', 4], ['#fff', 1.5]]) {
      Object.assign(pen, { strokeStyle: colour, lineWidth: width });
      pen.beginPath();
      for (const [du, dv] of Object.values(ARROWS)) {
        pen.moveTo(middle + 7 * du, middle + 7 * dv);
        pen.lineTo(middle + 26 * du, middle + 26 * dv);
      }
      pen.stroke();
    }
  }
  hideLens() {
    if (!this.cross) this.lens.hidden = true;
  }
}
