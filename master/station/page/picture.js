// The newest camera image and its age.
import { LATER_S, ageWords, figure, write } from './words.js';

const STALE_S = 0.2, RECORDED_S = 1.2;  // a recording keeps two images per second

export class PicturePanel {
  constructor(link) {
    this.link = link;
    this.canvas = document.getElementById('picture-canvas');
    this.context = this.canvas.getContext('2d');
    this.shownT = null;
    this.busy = false;
    this.next = null;
  }
  // The image is of another session.
  forget() {
    this.shownT = null;
  }
  take(message) {
    this.next = message;
    if (!this.busy) this.decode();
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
      document.getElementById('picture-empty').textContent = 'The image could not be decoded.';
    }
    this.busy = false;
    if (this.next) this.decode();
  }
  show(status) {
    const now = this.link.now();
    const age = this.shownT === null || now === null ? null : now - this.shownT, isLater = Boolean(status?.replay) && age < -LATER_S;
    write(document.getElementById('picture-age'), isLater ? '' : ageWords(age, false));
    this.canvas.hidden = isLater || this.shownT === null;
    this.showWhyNone(isLater, status);
    const stale = document.getElementById('picture-stale');
    stale.hidden = !(age > (status?.replay ? RECORDED_S : STALE_S));
    if (!stale.hidden) stale.textContent = `FROZEN for ${age.toFixed(1)} s`;
    this.showChecks(status);
  }
  showWhyNone(isLater, status) {
    const empty = document.getElementById('picture-empty');
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
