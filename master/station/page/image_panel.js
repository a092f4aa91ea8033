// Shows the newest camera image with its age, and the displacement of the model in colours over it.
import { viridisBar } from './colours.js';
import { drawField, magnitudesOf, visibleOf } from './field.js';
import { LATER_S, ageWords, figure, lengthUnit, write } from './text.js';

const STALE_S = 0.2, RECORDED_S = 0.5;  // a recording keeps eight images per second
const MIN_FULL = 1e-3;  // smallest displacement at full colour, relative to the size of the object
const OPACITY = 0.72;

export class ImagePanel {
  constructor(link, colourScale) {
    const byId = (id) => document.getElementById(id);
    Object.assign(this, { link, colourScale, shownT: null, busy: false, next: null, newest: null, past: null });
    Object.assign(this, { topology: null, field: null, showsField: true, drawn: '' });
    this.canvas = byId('image-canvas');
    this.context = this.canvas.getContext('2d');
    this.cover = byId('field-canvas');
    this.layer = document.createElement('canvas');
    this.bar = byId('field-bar');
    this.bar.querySelector('i').style.background = viridisBar('right');
  }
  // Clears the image, because it is of another session.
  forget() {
    Object.assign(this, { shownT: null, newest: null, field: null });
  }
  take(message) {
    this.newest = message;
    if (!this.past) this.put(message);
  }
  put(message) {
    this.next = message;
    if (!this.busy) this.decode();
  }
  // `topology`, `field`: results of fieldTopologyOf and fieldOf (link.js).
  takeFieldTopology(topology) {
    const { rest } = topology, extent = [0, 1, 2].map((axis) => extentOf(rest, axis));
    Object.assign(this, { topology, field: null, size: Math.hypot(...extent), isPlanar: extent[2] === 0 });
  }
  takeField(field) {
    this.field = field;
  }
  // Shows a moment of the last minute, {image, field, words}; null: the newest image again.
  showPast(past) {
    const wasPast = Boolean(this.past);
    this.past = past;
    const message = past ? past.image : wasPast ? this.newest : null;
    if (message) this.put(message);
  }
  toggleField() {
    this.showsField = !this.showsField;
    document.getElementById('field').setAttribute('aria-pressed', String(this.showsField));
    this.link.send({ do: 'field', on: this.showsField });
    if (!this.showsField) this.field = null;
  }
  async decode() {
    const message = this.next;
    this.next = null;
    this.busy = true;
    try {
      const bitmap = await createImageBitmap(new Blob([new Uint8Array(message.buffer, 16)], { type: 'image/jpeg' }));
      if (this.canvas.width !== bitmap.width || this.canvas.height !== bitmap.height) {
        this.canvas.width = bitmap.width;
        this.canvas.height = bitmap.height;
      }
      this.context.drawImage(bitmap, 0, 0);
      bitmap.close();
      this.shownT = message.t;
    } catch {
      document.getElementById('image-empty').textContent = 'The image could not be decoded.';
    }
    this.busy = false;
    if (this.next) this.decode();
  }
  show(status) {
    const now = this.link.now();
    const age = this.shownT === null || now === null ? null : now - this.shownT;
    const isLater = Boolean(status?.replay) && age < -LATER_S && !this.past;
    write(document.getElementById('image-age'), isLater ? '' : this.past ? this.past.words : ageWords(age, false));
    this.canvas.hidden = isLater || this.shownT === null;
    this.showWhyNone(isLater, status);
    const stale = document.getElementById('image-stale'), oldest = status?.replay ? RECORDED_S : STALE_S;
    stale.hidden = this.past || !(age > oldest);
    if (!stale.hidden) stale.textContent = `FROZEN for ${age.toFixed(1)} s`;
    this.showField(oldest);
    this.showChecks(status);
  }
  // Draws the field over the image of the same time; no field if they are more than `apart` [s]
  // apart.
  showField(apart) {
    const field = this.past ? this.past.field : this.field, { topology, cover, canvas } = this;
    const isOfImage = Boolean(field?.image) && field.number === topology?.number && Math.abs(field.t - this.shownT) <= apart;
    const isShown = this.showsField && !canvas.hidden && isOfImage;
    cover.hidden = this.bar.hidden = !isShown;
    if (!isShown) return;
    const ratio = devicePixelRatio, [width, height] = [cover.clientWidth, cover.clientHeight].map((size) => Math.round(ratio * size));
    const key = `${field.t} ${width} ${height} ${canvas.width}`;
    if (key === this.drawn) return;
    this.drawn = key;
    const magnitudes = magnitudesOf(field.displacement), { image } = field;
    this.colourScale.raise('moved', Math.max(...magnitudes), MIN_FULL * this.size);
    const full = this.colourScale.full.moved, scale = Math.min(width / canvas.width, height / canvas.height);
    const [left, top] = [(width - scale * canvas.width) / 2, (height - scale * canvas.height) / 2];
    for (const sheet of [this.layer, cover]) Object.assign(sheet, { width, height });
    drawField(
      this.layer.getContext('2d'),
      visibleOf(topology.triangles, image, this.isPlanar),
      magnitudes.map((value) => value / full),
      (node) => [left + scale * (image[2 * node] + 0.5), top + scale * (image[2 * node + 1] + 0.5)],
    );
    const pen = cover.getContext('2d');
    pen.globalAlpha = OPACITY;
    pen.drawImage(this.layer, 0, 0);
    const { unit, factor } = lengthUnit(full);
    write(this.bar.firstElementChild, field.isSolved ? 'displacement' : 'no solution; last displacement');
    write(this.bar.lastElementChild, `${figure(full * factor)} ${unit}`);
  }
  showWhyNone(isLater, status) {
    const empty = document.getElementById('image-empty');
    empty.hidden = this.shownT !== null && !isLater;
    if (isLater) write(empty, 'No image was recorded at this moment.');
    else if (this.shownT === null && status?.video_trouble) write(empty, `No image: ${status.video_trouble}`);
  }
  showChecks(status) {
    const details = status?.slave_state?.details || {};
    const names = {
      score: ['score', ''],
      contour_px: ['contour', ' px'],
      registration_px: ['registration', ' px'],
      epipolar_px: ['epipolar', ' px'],
      camera_motion_px: ['camera moved', ' px'],
      misfit: ['misfit', ' sigma'],
      rest_drift: ['baseline drift', ' counts'],
    };
    const checks = Object.entries(names)
      .filter(([key]) => Number.isFinite(details[key]))
      .map(([key, [name, unit]]) => `${name} ${figure(details[key])}${unit}`);
    write(document.getElementById('seen'), checks.length ? `checks: ${checks.join(', ')}` : '');
  }
}

function extentOf(rest, axis) {
  let [low, high] = [Infinity, -Infinity];
  for (let i = axis; i < rest.length; i += 3) [low, high] = [Math.min(low, rest[i]), Math.max(high, rest[i])];
  return high - low;
}
