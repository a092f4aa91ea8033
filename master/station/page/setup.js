// The set-up leads in steps from a frozen image to a scene that the slave uses. setup_scene.js
// interprets the answers.
import { CHECK_HELP, callWords, mistakeWords } from './setup_text.js';
import { crossesItself, distance, nearestOn } from './setup_geometry.js';
import { HeldPress, fitModulus, modelProblem, newtons } from './setup_identify.js';
import { Pointing } from './setup_pointing.js';
import { quantity } from './setup_quantities.js';
import { firstOpen, questionsAt, sentencesOf } from './setup_questions.js';
import {
  Answers,
  GUESS_OFF,
  MATERIALS,
  PressCurve,
  STEPS,
  angleAt,
  arcBetween,
  boardProblems,
  edgesOf,
  foundOf,
  heldLines,
  isComplete,
  isInArc,
  isRound,
  mm,
  outlineOf,
  pixelOf,
  problemsAt,
  sceneOf,
  startOf,
  stepOfKey,
  toolPixelOf,
  viewOf,
} from './setup_scene.js';
import { findTip, greyOf, imageTrouble, ontoEdge } from './setup_tip.js';
import { noteItem } from './alarms.js';
import { save, zipOf } from './save.js';
import { VALIDITY, codeOf, figure, interval, write } from './text.js';

const byId = (id) => document.getElementById(id);
const NAMES = Object.keys(STEPS);
const HINTS = {
  image: 'The tool is held a few millimetres above the untouched object, a ruler lies in their plane, and the lens is as high as the ' +
    'gap between object and tool.',
  scale: 'Click two marks of a ruler that are far apart, or let a printed board be found.',
  object: 'Click around the object. The slave then pulls the outline to the edge.',
  held: 'Click the edges where the object is held. Click again to free an edge.',
  material: 'How soft is the object?',
  tool: 'Drag a box around the tip: some of the tool, some background on both sides, and a little before the tip.',
  check: 'The slave checks the scene.',
  press: 'Press the object with the tool.',
};
const ARCS_HINT = 'Click the two ends of each part of the edge that is held. Click a held part again to free it.';
const EDGE_NAMES = ['lower', 'right', 'upper', 'left'];  // edges of a rectangle
const EDGE_PX = 14;  // largest distance from a click to the edge that it selects [px on the screen]

const bytesOf = (base64) => Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
const base64Of = (bytes) => btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(''));

export class Setup {
  constructor(imagePanel) {
    Object.assign(this, {
      imagePanel,
      answers: new Answers(),
      step: 'image',
      frozen: null,
      scene: null,
      wanted: null,
      preview: null,
      trouble: {},
      report: null,
      curve: new PressCurve(),
      held: new HeldPress(),
      state: null,
      busy: '',
      pending: null,
      images: 0,
    });
    this.canvas = byId('setup-canvas');
    this.pen = this.canvas.getContext('2d', { willReadFrequently: true });
    byId('setup-steps').replaceChildren(...NAMES.map((name, i) => this.stepItem(name, i)));
    byId('setup-material').replaceChildren(new Option('choose', ''), ...MATERIALS.map((name) => new Option(name, name)));
    byId('setup-open').addEventListener('click', () => this.show(true));
    byId('setup-close').addEventListener('click', () => this.show(false));
    byId('setup-undo').addEventListener('click', () => this.undo());
    byId('setup-back').addEventListener('click', () => this.go(NAMES[NAMES.indexOf(this.step) - 1]));
    byId('setup-next').addEventListener('click', () => this.next());
    byId('setup-board').addEventListener('click', () => this.findBoard());
    byId('setup-pull').addEventListener('click', () => this.pull());
    byId('setup-freeze').addEventListener('click', () => this.freeze());
    byId('setup-live').addEventListener('click', () => (this.answers.set('image', null), this.changed()));
    byId('setup-use').addEventListener('click', () => this.use());
    byId('setup-right').addEventListener('click', () => this.confirm(this.sentencesText));
    byId('setup-wrong').addEventListener('click', () => { this.doubts = true; this.draw(); });
    byId('setup-erase').addEventListener('click', () => this.erase());
    byId('setup-other-part').addEventListener('click', () => this.holdOtherPart());
    for (const [id, factor] of [
      ['setup-nearer', 1.5],
      ['setup-farther', 1 / 1.5],
      ['setup-fit', 0],
    ])
      byId(id).addEventListener('click', () => this.pointing.zoomMiddle(factor));
    byId('setup-download').addEventListener('click', () => this.download());
    byId('setup-clear').addEventListener('click', () => { this.curve = new PressCurve(); });
    byId('setup-hold').addEventListener('click', () => this.holdPress());
    byId('setup-add').addEventListener('click', () => this.addReading());
    byId('setup-use-modulus').addEventListener('click', () => this.useModulus());
    byId('setup-form').elements['press.reading'].addEventListener('keydown', (event) => event.key === 'Enter' && this.enter(event));
    byId('setup-form').addEventListener('submit', (event) => event.preventDefault());
    byId('setup-form').addEventListener('change', ({ target }) => this.takeField(target));
    byId('setup-form').addEventListener('input', ({ target }) => this.showUnit(target));
    this.pointing = new Pointing(this.canvas, byId('setup-lens'), {
      isOpen: () =>
        Boolean(this.frozen) &&
        !this.busy &&
        ['scale', 'object', 'held', 'tool'].includes(this.step) &&
        !(this.step === 'scale' && this.answers.now.scale.by === 'board'),
      points: () => this.pointsAt(this.step),
      takesBox: () => this.step === 'tool',
      click: (at) => this.click(at),
      move: (i, at) => this.movePoint(i, at),
      box: (from, to) => this.takeBox(from, to),
      preview: (preview) => {
        this.preview = preview;
        this.draw();
      },
      redraw: () => this.draw(),
      tell: (words) => write(byId('setup-place'), words),
    });
    window.addEventListener('keydown', (event) => this.key(event));
  }
  stepItem(name, i) {
    const item = document.createElement('li'), button = document.createElement('button');
    button.type = 'button';
    button.dataset.step = name;
    button.textContent = `${i + 1} ${STEPS[name]}`;
    button.addEventListener('click', () => this.go(name));
    item.append(button);
    return item;
  }

  // Processes the slave's report: whether it accepts a set-up, and whether it has a scene.
  takeHealth({ scene }) {
    if (!scene) return;  // the slave restarts or does not answer
    this.running = scene;
    const lines = scene?.setup_camera || '';
    byId('setup-open').hidden = !lines;
    this.cameraLines = lines.split('\n').map((line) => line.trim()).filter(Boolean);
    if (lines && this.kept === undefined) this.restore();
    const isOn = Boolean(lines) && (this.wanted ?? !scene.name);
    if (isOn !== this.isShown) this.show(isOn, false);
  }
  takeStatus({ slave_state: state }) {
    this.state = state;
    if (!state || this.step !== 'press') return;
    const point = this.curve.add(state, pixelOf(this.answers.now));
    if (point) this.point = point;
    if (point && this.identifies)
      this.held.add(
        { ...point, sigma: Math.sqrt(Math.max(0, point.sigma ** 2 - (1e-2 * GUESS_OFF * point.force) ** 2)) },
        performance.now(),
      );
  }
  show(isOn, byHand = true) {
    if (byHand) this.wanted = isOn;
    byId('setup').hidden = !isOn;
    document.body.classList.toggle('setting-up', isOn);
    if (byHand) this.keep();
    if (isOn) this.draw();
  }
  // Stores step and answers for a reload of the page in the browser's storage of this tab.
  keep() {
    const { now } = this.answers,
      kept = {
        camera: this.cameraLines,
        step: this.step,
        isShown: this.isShown,
        now: { ...now, image: now.image && { ...now.image, frozen: null } },
      };
    const jpeg = now.image?.frozen.jpeg || '';
    try {
      sessionStorage.setItem('setup', JSON.stringify(kept));
      if (jpeg === this.kept) return;
      this.kept = jpeg;
      sessionStorage.removeItem('setup-image');
      sessionStorage.setItem('setup-image', jpeg);
    } catch {}  // without storage, or with an image that is too large, a reload begins with a new image
  }
  async restore() {
    this.kept = '';
    let kept = null, jpeg = null;
    try {
      [kept, jpeg] = [JSON.parse(sessionStorage.getItem('setup')), sessionStorage.getItem('setup-image')];
    } catch {}  // without storage
    // The stored answers belong to another slave.
    if (!kept || String(kept.camera) !== String(this.cameraLines)) return;
    this.wanted = kept.isShown || null;
    const frozen = kept.now.image && jpeg ? await this.decode(jpeg).catch(() => null) : null;
    this.images = kept.now.image?.number || 0;
    this.answers.now = { ...kept.now, image: frozen && { ...kept.now.image, frozen } };
    this.step = kept.step === 'press' && !this.running.name ? 'check' : kept.step;
    if (!frozen) this.step = 'image';
    this.changed();
    if (kept.isShown) this.show(true);
    this.go(this.step);
  }
  // Returns whether the image is frozen.
  get isFrozen() {
    return Boolean(this.frozen) && this.step !== 'press';
  }
  get isShown() {
    return !byId('setup').hidden;
  }

  go(step) {
    if (!step) return;
    if (step !== this.step) this.pointing.reset();
    this.step = step;
    this.doubts = false;
    write(byId('setup-place'), '');
    if (step === 'check') this.propose();
    this.keep();
    this.draw();
    const { activeElement: focused } = document;
    if (focused && focused !== document.body && !focused.checkVisibility()) this.stepButton.focus();
  }
  get stepButton() {
    return document.querySelector(`#setup-steps [data-step=${this.step}]`);
  }
  next() {
    this.trouble[this.step] = null;
    if (!problemsAt(this.step, this.answers.now).length && !questionsAt(this.step, this.answers.now).length && !this.busy)
      return this.go(NAMES[NAMES.indexOf(this.step) + 1]);
    this.tried = this.step;  // from now on the step shows what is missing
    this.draw();
  }
  undo() {
    this.answers.undo(this.step);
    this.trouble[this.step] = null;
    this.changed();
  }
  key(event) {
    if (!this.isShown || event.key !== 'z' || !(event.ctrlKey || event.metaKey)) return;
    event.preventDefault();
    this.undo();
  }
  // Stores that a question was answered with "right".
  confirm(text) {
    this.answers.set('confirmed', [...this.answers.now.confirmed, text]);
    this.keep();
    this.draw();
  }
  // Reacts to a question answered with "wrong": by an act, another step, or a field.
  correct(wrong) {
    const { tool, object } = this.answers.now;
    if (wrong === 'otherShape') this.answers.change('tool', { shape: tool.shape === 'round' ? 'flat' : 'round' });
    else if (wrong === 'useClicks') this.answers.change('object', { ...object, found: null, clear: null });
    else if (wrong in STEPS) return this.go(wrong);
    else {
      const fields = byId('setup-form').elements[wrong];
      return (fields?.focus ? fields : fields?.[0])?.focus();
    }
    this.changed();
  }

  // Called after each change. Searches the tip again, because it depends on outline and scale.
  changed() {
    const { image, tool, object, scale } = this.answers.now;
    this.report = null;
    this.frozen = image?.frozen || null;
    const key = JSON.stringify([tool.box, tool.width, tool.shape, tool.by, tool.depth, object, scale, image?.number]);
    if (key !== this.searched) {
      this.searched = key;
      this.answers.now.tool = { ...tool, seen: this.tipIn(tool) };
    }
    this.keep();
    this.draw();
  }
  tipIn({ box, width, shape }) {
    const outline = outlineOf(this.answers.now), px = mm(width) / toolPixelOf(this.answers.now);
    if (box.length < 2 || !this.frozen || !outline.length || !(px > 0)) return null;
    return px >= 3
      ? findTip(this.frozen.grey, box, outline, px, shape === 'round', viewOf(this.answers.now))
      : { why: `The tip is ${px.toFixed(1)} px wide in the image: expected at least 3 px. Move the camera nearer, or correct the width.` };
  }
  takeField(field) {
    const [step, key] = (field.name || '').split('.');
    if (!key || (field.type !== 'checkbox' && this.valueOf(field) === field.value)) return;
    if (step === 'name') {  // a new name leaves the check valid
      this.answers.set('name', field.value);
      this.keep();
      return this.draw();
    }
    if (key === 'kind') this.answers.change('object', { kind: field.value, points: [], found: null, clear: null });
    else if (field.type === 'checkbox')
      this.answers.set(
        'held',
        field.checked
          ? [...this.answers.now.held, Number(key)].sort((a, b) => a - b)
          : this.answers.now.held.filter((i) => i !== Number(key)),
      );
    else this.answers.change(step, { [key]: field.value });
    if (key === 'kind') this.answers.set('held', []);
    this.trouble[step] = null;
    this.changed();
  }

  // Calls the slave. Returns its reply, or null and shows the reason at `step`.
  // One call at a time: what a person has pressed waits for `pending`, and is asked once.
  async call(name, step, request, words) {
    if (this.busy) return null;
    this.pending = this.send(name, step, request, words);
    return this.pending;
  }
  async send(name, step, request, words) {
    this.busy = words;
    this.draw();
    const token = location.hash.slice(1);
    let reply = null;
    try {
      const response = await fetch(`/setup/${name}${token && `?token=${token}`}`, { method: 'POST', body: JSON.stringify(request) });
      reply = await response.json().catch(() => ({ error: `palpate-master answers ${response.status} ${response.statusText}` }));
      if (response.ok && !reply.error) this.trouble[step] = null;
      else this.trouble[step] = [this.troubleOf(name, { error: `palpate-master answers ${response.status}`, ...reply })];
      if (!response.ok || reply.error) reply = null;
    } catch {
      reply = null;
      this.trouble[step] = ['palpate-master does not answer. Your answers are kept: try again.'];
    }
    this.busy = '';
    this.draw();
    return reply;
  }
  // If the slave rejects a scene when it begins to use it, the reason comes as text.
  troubleOf(name, reply) {
    const [, key, value, message, expected] =
      (name === 'use' &&
        reply.reason === 'INVALID_FIELD' &&
        reply.error.match(
          /^(?:line \d+: )?((?:object|sense|tool|model|manipulator)[a-z_.]*)(?: = ([^:]*))?: (.*?)(?:: expected (.*))?$/m,
        )) ||
      [];
    return key ? mistakeWords({ key, value, message, expected }) : { text: callWords(name, reply), details: reply.error };
  }
  async freeze() {
    await this.pending;
    const reply = await this.call('image', 'image', {}, 'An image is fetched ...');
    if (!reply) return;
    try {
      const frozen = await this.decode(reply.jpeg), { grey } = frozen;
      this.answers.set('image', { width: grey.width, height: grey.height, number: ++this.images, trouble: imageTrouble(grey), frozen });
    } catch {
      this.trouble.image = ['The image cannot be decoded. Freeze again.'];
    }
    this.changed();
  }
  async decode(jpeg) {
    const bitmap = await createImageBitmap(new Blob([bytesOf(jpeg)], { type: 'image/jpeg' }));
    const still = new OffscreenCanvas(bitmap.width, bitmap.height), pen = still.getContext('2d', { willReadFrequently: true });
    pen.drawImage(bitmap, 0, 0);
    return { still, grey: greyOf(pen.getImageData(0, 0, bitmap.width, bitmap.height)), jpeg };
  }
  async findOutline() {
    const start = startOf(this.answers.now.object).map(([u, v]) => ({ u, v }));
    const reply = await this.call('outline', 'object', { image: this.frozen.jpeg, near: start }, 'The slave looks for the edge ...');
    if (!reply) return;
    const { object } = this.answers.now, near = foundOf(object, reply.outline.map(({ u, v }) => [u, v]));
    const found = isRound(object) ? ontoEdge(this.frozen.grey, near) : near;
    // The outline belongs to the previous clicks.
    this.answers.now = { ...this.answers.now, object: { ...this.answers.now.object, found, clear: reply.clear } };
    this.changed();
  }
  async findBoard() {
    await this.pending;
    const { scale } = this.answers.now;
    this.trouble.scale = boardProblems(this.answers.now);
    if (this.trouble.scale.length) return this.draw();
    const request = {
      images: [this.frozen.jpeg],
      columns: quantity(scale.columns, 'plain').value,
      rows: quantity(scale.rows, 'plain').value,
      square: mm(scale.square),
    };
    const reply = await this.call('board', 'scale', request, 'The slave looks for the board ...');
    if (!reply) return;
    this.answers.change('scale', { board: { pixel: reply.pixel, points: reply.corners.map(({ u, v }) => [u, v]) } });
    this.changed();
  }
  async proposal() {
    const [[u0, v0], [u1, v1]] = this.answers.now.tool.seen.box, cut = new OffscreenCanvas(u1 - u0 + 1, v1 - v0 + 1);
    cut.getContext('2d').drawImage(this.frozen.still, -u0, -v0);
    const template = new Uint8Array(await (await cut.convertToBlob({ type: 'image/png' })).arrayBuffer());
    const { scene, files } = sceneOf(this.answers.now, this.cameraLines, template);
    return { scene, files: { ...files, 'image.jpg': bytesOf(this.frozen.jpeg) } };
  }
  requestOf({ scene, files }) {
    return { scene, files: Object.fromEntries(Object.entries(files).map(([name, bytes]) => [name, base64Of(bytes)])) };
  }
  // Checks the scene. Errors are shown at the step that owns their key.
  async propose() {
    await this.pending;
    const first = firstOpen(this.answers.now);
    if (first) {
      this.step = this.tried = first;
      return this.draw();
    }
    const proposal = await this.proposal(),
      reply = await this.call('propose', 'check', this.requestOf(proposal), 'The slave checks the scene ...');
    if (!reply) return;
    this.scene = proposal;
    if (reply.errors?.length) this.assign(reply.errors);
    else if (reply.contact) this.report = reply;
    else
      this.trouble.check = [
        {
          text: 'The slave finds no force for this tool and these held edges: check that the edge that you press is free, and the sizes.',
          details: reply.report,
        },
      ];
    this.draw();
  }
  // Assigns errors of the slave to the steps that own their keys, and goes to the first of these.
  assign(errors) {
    for (const error of errors) {
      const words = mistakeWords(error);
      (this.trouble[stepOfKey(words.key)] ||= []).push(words);
    }
    this.step = NAMES.find((name) => this.trouble[name]?.length) || 'check';
  }
  async use() {
    if (!this.report) return this.propose();
    if (!this.isConfirmed) return this.draw();
    this.scene = await this.proposal();  // the checked scene except for its name
    this.wanted = true;  // because the slave may report its scene before it answers
    const reply = await this.call('use', 'check', this.requestOf(this.scene), 'The slave takes the scene into use ...');
    if (!reply) return;
    this.curve = new PressCurve();
    // The readings belong to the previous scene.
    this.answers.change('press', { held: null, reading: '', readings: [] });
    this.go('press');
  }
  // The questions of step `check`: the whole set-up in sentences.
  get sentences() {
    return this.report ? sentencesOf(this.answers.now, this.report.report) : [];
  }
  get sentencesText() {
    return this.sentences.map(({ text }) => text).join(' ');
  }
  get isConfirmed() {
    return Boolean(this.report) && this.answers.now.confirmed.includes(this.sentencesText);
  }
  // Whether step `press` identifies the modulus with a scale, because it is a guess.
  get identifies() {
    return this.answers.now.material.by === 'identify';
  }
  enter(event) {
    event.preventDefault();
    if (!this.answers.now.press.held) return this.holdPress();
    this.takeField(event.target);
    return this.addReading();
  }
  holdPress() {
    const kind = this.running?.model?.kind, held = this.held.take(performance.now()), why = modelProblem(kind) || held.why;
    this.trouble.press = why ? [why] : null;
    if (!why) this.answers.change('press', { held: { ...held, modulus: this.running.material.young_modulus }, reading: '' });
    byId('setup-form').elements['press.reading'].focus();
    this.changed();
  }
  addReading() {
    const { held, reading, unit, readings } = this.answers.now.press, value = newtons(reading, unit);
    this.trouble.press = !held ? ['Hold a press first.'] : value > 0 ? null : ['Reading of the scale: expected a number above 0.'];
    if (!this.trouble.press)
      this.answers.change('press', {
        held: null,
        reading: '',
        readings: [...readings, { ...held, reading: value, words: `${reading} ${unit}` }],
      });
    if (!this.trouble.press) byId('setup-form').elements['press.reading'].value = '';
    this.changed();
  }
  get fitted() {
    const { readings, resolution, unit } = this.answers.now.press, step = newtons(resolution, unit);
    return step > 0 ? fitModulus(readings, step) : null;
  }
  useModulus() {
    const { modulus, tolerance } = this.fitted, words = String(Number((1e-3 * modulus).toPrecision(4)));
    this.answers.change('material', {
      by: 'modulus',
      modulus: words,
      identified: words,
      tolerance: String(Number((100 * tolerance).toPrecision(2))),
    });
    this.report = null;
    this.go('check');
  }
  async download() {
    const scene = this.scene || (firstOpen(this.answers.now) ? null : await this.proposal());
    if (!scene) return this.go('check');
    save(
      new Blob([zipOf({ 'scene.yaml': new TextEncoder().encode(scene.scene), ...scene.files })], { type: 'application/zip' }),
      `${this.answers.now.name}.zip`,
    );
  }

  // Processes a click at a position in the frozen image [px].
  click(at) {
    this.trouble[this.step] = null;
    ({ scale: () => this.clickScale(at), object: () => this.clickObject(at), held: () => this.clickEdge(at), tool: () => this.draw() })[
      this.step
    ]?.();
  }
  // The points of a step that can be moved.
  pointsAt(step) {
    const { scale, object, tool } = this.answers.now;
    return { scale: scale.by === 'clicks' ? scale.points : [], object: object.points, tool: tool.box }[step] || [];
  }
  // Returns the points of a step, with a dragged point at its present position.
  shownPoints(step) {
    const points = this.pointsAt(step), { preview } = this;
    if (step !== this.step || !preview) return points;
    return preview.box || points.map((point, i) => (i === preview.i ? preview.at : point));
  }
  movePoint(i, at) {
    const { step } = this, points = this.pointsAt(step).map((point, k) => (k === i ? at : point));
    this.trouble[step] = null;
    if (step === 'tool') this.answers.change('tool', { box: points });
    else if (step === 'object') this.answers.change('object', { points, found: null, clear: null });
    else this.answers.change('scale', { points });
    this.changed();
    if (step === 'object' && this.answers.now.object.kind === 'rectangle' && isComplete(this.answers.now.object)) this.pull();
  }
  takeBox(from, to) {
    this.trouble.tool = null;
    if (distance(from, to) > 3) this.answers.change('tool', { box: [from, to] });
    this.changed();
  }
  // Removes the points of this step.
  erase() {
    const { step } = this;
    if (step === 'object') this.answers.change('object', { points: [], found: null, clear: null });
    else if (step === 'held') this.answers.set('held', []);
    else this.answers.change(step, step === 'tool' ? { box: [] } : { points: [] });
    this.trouble[step] = null;
    this.changed();
  }
  clickScale(at) {
    const { points } = this.answers.now.scale;
    if (points.length === 2) this.trouble.scale = ['Both marks are set. Drag one to move it, or press "Set the points again".'];
    else this.answers.change('scale', { points: [...points, at] });
    this.changed();
  }
  clickObject(at) {
    const { object } = this.answers.now;
    if (object.kind === 'rectangle' && object.points.length === 4) {
      this.trouble.object = ['All four corners are set. Drag one to move it, or press "Set the points again".'];
      return this.draw();
    }
    this.answers.change('object', { points: [...object.points, at], found: null, clear: null });
    // The edges of a polygon are those between the clicks.
    if (object.kind === 'polygon' && this.answers.now.held.length) this.answers.set('held', []);
    this.changed();
    const now = this.answers.now.object;
    if (isComplete(now) && now.kind === 'rectangle') this.pull();
  }
  pull() {
    const { object } = this.answers.now;
    if (isComplete(object) && !crossesItself(object.points)) this.findOutline();
    else this.next();
  }
  clickEdge(at) {
    const { now } = this.answers, reach = EDGE_PX / this.pointing.scale;
    if (isRound(now.object)) return this.clickArc(at, reach);
    const near = edgesOf(now).map((edge, i) => ({ i, far: nearestOn(edge, at, false).distance })).sort((a, b) => a.far - b.far)[0];
    if (!near || near.far > reach) {
      this.trouble.held = ['No edge is there: click on the line around the object.'];
      return this.draw();
    }
    this.answers.set(
      'held',
      now.held.includes(near.i) ? now.held.filter((i) => i !== near.i) : [...now.held, near.i].sort((a, b) => a - b),
    );
    this.changed();
  }
  // Sets one end of a fixed arc, or removes the clicked arc.
  clickArc(at, reach) {
    const { now } = this.answers, outline = outlineOf(now), near = outline.length ? nearestOn(outline, at) : null;
    if (!near || near.distance > reach) {
      this.trouble.held = ['No edge is there: click on the line around the object.'];
      return this.draw();
    }
    const angle = angleAt(now, near.at), open = now.held.find(({ to }) => to === undefined), whole = now.held.filter((arc) => arc !== open);
    const freed = open ? [] : whole.filter((arc) => isInArc(arc, angle));
    this.answers.set(
      'held',
      open
        ? [...whole, arcBetween(open.from, angle)]
        : freed.length
          ? whole.filter((arc) => !freed.includes(arc))
          : [...whole, { from: angle }],
    );
    this.changed();
  }
  // Replaces the last arc by the other part of the outline.
  holdOtherPart() {
    const { held } = this.answers.now, last = held.at(-1);
    if (last?.to !== undefined) this.answers.set('held', [...held.slice(0, -1), { from: last.to, to: last.from }]);
    this.changed();
  }

  // Shows everything. Called after each change, and for each new image while it is live.
  draw() {
    if (!this.isShown) return;
    const { now } = this.answers;
    byId('setup-live').hidden = !this.frozen;
    this.drawImage();
    for (const button of document.querySelectorAll('#setup-steps button')) {
      const name = button.dataset.step, isDone = NAMES.indexOf(name) < NAMES.indexOf('check') && !problemsAt(name, now).length;
      button.setAttribute('aria-current', name === this.step ? 'step' : 'false');
      button.classList.toggle('done', isDone || (name === 'check' && Boolean(this.report)));
    }
    for (const part of document.querySelectorAll('#setup-form [data-step]')) part.hidden = part.dataset.step !== this.step;
    for (const part of document.querySelectorAll('#setup-form [data-kind]'))
      part.hidden = !part.dataset.kind.split(' ').includes(now[part.closest('[data-step]').dataset.step].by || now.object.kind);
    for (const field of byId('setup-form').elements) this.fillField(field);
    byId('setup-freeze').dataset.count = now.image?.number || 0;
    write(byId('setup-hint'), this.busy || (this.step === 'held' && isRound(now.object) ? ARCS_HINT : HINTS[this.step]));
    byId('setup-erase').hidden = !this.pointsAt(this.step).length && !(this.step === 'held' && now.held.length);
    byId('setup-other-part').hidden = !(isRound(now.object) && now.held.at(-1)?.to !== undefined);
    byId('setup-undo').disabled = !this.answers.canUndo(this.step);
    byId('setup-back').hidden = this.step === 'image';
    byId('setup-next').hidden = NAMES.indexOf(this.step) >= NAMES.indexOf('check');
    byId('setup-use').disabled = !this.isConfirmed || Boolean(this.busy);
    this.showReport();
    this.showEdges();
    this.showProblems();
    this.showQuestions();
    this.showFacts();
  }
  valueOf({ name }) {
    const [step, key] = name.split('.');
    return step === 'name' ? this.answers.now.name : this.answers.now[step][key];
  }
  // Shows the unit beside a field, unless the answer contains a unit.
  showUnit(field) {
    const host = field.closest?.('.quantity');
    if (host) host.classList.toggle('own-unit', /[a-zµ%]\s*$/i.test(field.value));
  }
  fillField(field) {
    if (!field.name?.includes('.') || field === document.activeElement) return;
    if (field.type === 'checkbox') return;
    const value = this.valueOf(field);
    if (field.type === 'radio') field.checked = field.value === value;
    else if (field.value !== value) field.value = value;
    this.showUnit(field);
  }
  showProblems() {
    const own = this.tried === this.step ? problemsAt(this.step, this.answers.now) : [],
      list = [...(this.trouble[this.step] || []), ...own];
    if (this.step === 'image' && this.answers.now.image?.trouble && !own.length) list.push(this.answers.now.image.trouble);
    if (this.step === 'tool' && this.answers.now.tool.seen?.why && !own.length) list.push(this.answers.now.tool.seen.why);
    if (this.step === 'press' && this.identifies) list.push(...(this.fitted?.warnings || []));
    const unlike = list
      .map((item) => (item.text ? item : { text: item }))
      .filter(({ text }, i, all) => all.findIndex((other) => other.text === text) === i);
    const text = JSON.stringify(unlike);
    if (text === this.shownProblems) return;
    this.shownProblems = text;
    byId('setup-problems').replaceChildren(...unlike.map(({ text: words, details }) => {
      const item = Object.assign(document.createElement('li'), { textContent: words });
      if (details) item.append(detailsOf(details));
      return item;
    }));
  }
  showQuestions() {
    const asked = this.busy ? [] : questionsAt(this.step, this.answers.now), text = JSON.stringify(asked);
    if (text === this.shownQuestions) return;
    this.shownQuestions = text;
    byId('setup-questions').replaceChildren(...asked.map(({ text: words, wrong, words: [yes, no] = ['Right', 'Wrong'] }) => {
      const item = Object.assign(document.createElement('li'), { textContent: words }), acts = document.createElement('div');
      acts.append(buttonOf(yes, 'right', () => this.confirm(words)), buttonOf(no, 'wrong', () => this.correct(wrong)));
      item.append(acts);
      return item;
    }));
  }
  // Shows the edges of a rectangle or a polygon as check boxes, for use without a mouse.
  showEdges() {
    const { now } = this.answers, edges = edgesOf(now), host = byId('setup-edges');
    host.hidden = !edges.length;
    if (host.childElementCount - 1 !== edges.length) {
      host.replaceChildren(host.firstElementChild, ...edges.map((_, i) => {
        const label = document.createElement('label'),
          box = Object.assign(document.createElement('input'), { type: 'checkbox', name: `held.${i}` });
        label.append(box, document.createTextNode(now.object.kind === 'rectangle' ? EDGE_NAMES[i] : `edge ${i + 1}`));
        return label;
      }));
    }
    host.querySelectorAll('input').forEach((box, i) => { box.checked = now.held.includes(i); });
  }
  showAlarms(alarms) {
    const text = JSON.stringify(alarms);
    if (text === this.shownAlarms) return;
    this.shownAlarms = text;
    byId('setup-alarms').replaceChildren(...alarms.map(({ level, text: words, next }) => noteItem(level, words, next)));
  }
  // Shows step `check`: the set-up in sentences that a person confirms, the largest depth, and
  // under "details" the slave's report.
  showReport() {
    const { report, sentences } = this, list = byId('setup-sentences');
    byId('setup-plausible').hidden = !report;
    write(byId('setup-report'), report?.report || '');
    byId('setup-right').hidden = this.isConfirmed;
    byId('setup-doubts').hidden = !this.doubts;
    const text = JSON.stringify([sentences, this.doubts]);
    if (text !== this.shownSentences) {
      list.replaceChildren(...sentences.map(({ text: words, step }) => {
        const item = Object.assign(document.createElement('li'), { textContent: words });
        if (this.doubts) item.append(buttonOf('Correct', 'wrong', () => this.go(step)));
        return item;
      }));
    }
    this.shownSentences = text;
    const { contact } = report || {};
    const depth = contact?.largest_depth
      ? ` The model is made for at most ${figure(1e3 * contact.largest_depth)} mm of depth. A check may flag forces earlier.`
      : '';
    write(
      byId('setup-contact'),
      contact ? `At ${figure(1e3 * contact.depth)} mm depth the force is about ${figure(contact.force)} N.${depth}` : '',
    );
  }
  showFacts() {
    const { now } = this.answers, pixel = pixelOf(now), { clear } = now.object, { seen } = now.tool;
    write(byId('setup-scale-fact'), pixel > 0 ? `${figure(1e3 * pixel)} mm per pixel` : '');
    write(byId('setup-object-fact'), clear === null ? '' : `${Math.round(100 * clear)} % of the outline lie on a clear edge.`);
    write(
      byId('setup-tool-fact'),
      seen?.tip
        ? `Tip found at (${seen.tip.map((value) => value.toFixed(1)).join(', ')}) px, ${figure(1e3 * seen.width * toolPixelOf(now))} mm wide.`
        : '',
    );
    const { length: held } = now.held,
      edges = edgesOf(now).length,
      isOpen = held && now.held.at(-1).from !== undefined && now.held.at(-1).to === undefined;
    write(
      byId('setup-held-fact'),
      isRound(now.object)
        ? `${held - (isOpen ? 1 : 0)} parts of the edge are held.${isOpen ? ' Click the other end.' : ''}`
        : `${held} of ${edges} edges are held.`,
    );
    if (this.step === 'press') this.showPress();
  }
  showPress() {
    const { state, point } = this, validity = codeOf(state?.validity, 'VALIDITY_'), check = codeOf(state?.check, 'FAILED_CHECK_');
    write(byId('setup-force'), state?.force && point ? forceWords(point) : 'no force yet');
    const [level, words] = VALIDITY[validity] || ['idle', 'waiting for the first force'];
    byId('setup-validity').dataset.level = level;
    write(byId('setup-validity'), words + (CHECK_HELP[check] ? `: ${CHECK_HELP[check]}` : ''));
    write(
      byId('setup-largest'),
      this.curve.largestValid > 0 ? `Largest valid depth so far: ${figure(1e3 * this.curve.largestValid)} mm` : '',
    );
    drawCurve(byId('setup-curve'), this.curve.points);
    byId('setup-identify').hidden = !this.identifies;
    if (this.identifies) this.showReadings();
  }
  showReadings() {
    const { held, readings } = this.answers.now.press, { fitted } = this;
    write(byId('setup-held'), held ? `${figure(held.force)} N at ${figure(1e3 * held.depth)} mm are held: type the reading.` : '');
    const rows = readings.map(({ words, force, depth }, i) => `${i + 1}: ${words} for ${figure(force)} N at ${figure(1e3 * depth)} mm`);
    if (rows.join() !== this.shownReadings)
      byId('setup-readings').replaceChildren(...rows.map((textContent) => Object.assign(document.createElement('li'), { textContent })));
    this.shownReadings = rows.join();
    const [modulus, half] = fitted ? interval(1e-3 * fitted.modulus, 1e-3 * fitted.half) : [];
    write(byId('setup-modulus'), fitted ? `Young's modulus ${modulus} kPa ± ${half} kPa (95 %)` : '');
    byId('setup-use-modulus').disabled = !fitted;
  }
  drawImage() {
    const live = !this.isFrozen, source = live ? this.imagePanel.canvas : this.frozen.still;
    if (this.canvas.width !== source.width || this.canvas.height !== source.height)
      [this.canvas.width, this.canvas.height] = [source.width, source.height];
    this.pen.drawImage(source, 0, 0);
    if (!live) this.drawAnswers();
  }
  drawAnswers() {
    const { pen, answers: { now } } = this, px = 1 / this.pointing.scale, width = 1.8 * px;
    const tone = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);
    const path = (points, isClosed) => {
      pen.beginPath();
      points.forEach(([u, v], i) => pen[i ? 'lineTo' : 'moveTo'](u + 0.5, v + 0.5));
      if (isClosed) pen.closePath();
    };
    // A bright line above a dark one is visible on every image.
    const line = (points, colour, isClosed = false, thick = 1) => {
      path(points, isClosed);
      for (const [strokeStyle, lineWidth] of [['#000a', (thick + 1.3) * width], [colour, thick * width]]) {
        Object.assign(pen, { strokeStyle, lineWidth, lineJoin: 'round' });
        pen.stroke();
      }
    };
    const dots = (points, colour) => points.forEach(([u, v]) => {
      line([[u - 6 * px, v], [u + 6 * px, v]], colour);
      line([[u, v - 6 * px], [u, v + 6 * px]], colour);
    });
    const handles = (step, colour) => this.step === step && this.shownPoints(step).forEach(([u, v]) => {
      path(
        Array.from({ length: 16 }, (_, i) => [u + 5 * px * Math.cos((i * Math.PI) / 8), v + 5 * px * Math.sin((i * Math.PI) / 8)]),
        true,
      );
      Object.assign(pen, { strokeStyle: '#000a', lineWidth: 2.3 * width });
      pen.stroke();
      Object.assign(pen, { strokeStyle: colour, lineWidth: width });
      pen.stroke();
    });
    const scaleTone = '#ffb454', objectTone = '#5ab4ff', heldTone = '#ff5a64', toolTone = '#a6e36b';
    const isBoard = now.scale.by === 'board', marks = this.shownPoints('scale');
    if (isBoard) dots(now.scale.board?.points || [], scaleTone);
    else if (this.step === 'scale') line(marks, scaleTone), handles('scale', scaleTone);
    const outline = this.preview && this.step === 'object' ? [] : outlineOf(now);
    line(outline.length ? outline : this.shownPoints('object'), objectTone, outline.length > 0);
    handles('object', objectTone);
    for (const part of heldLines(now)) line(part, heldTone, false, 2.2);
    if (this.step === 'held' && isRound(now.object) && outline.length) this.drawEnds(dots, outline, heldTone);
    const box = this.shownPoints('tool');
    if (box.length === 2) line([box[0], [box[1][0], box[0][1]], box[1], [box[0][0], box[1][1]]], toolTone, true);
    handles('tool', toolTone);
    if (now.tool.seen?.tip && !this.preview) dots([now.tool.seen.tip], heldTone);
    if (this.pointing.cross) dots([this.pointing.cross], tone('--setup-cross') || '#fff');
  }
  // Draws the ends of fixed arcs.
  drawEnds(dots, outline, colour) {
    const { now } = this.answers;
    for (const { from, to } of now.held) {
      for (const angle of [from, to].filter((value) => value !== undefined)) {
        const off = (point) => Math.abs(Math.atan2(Math.sin(angleAt(now, point) - angle), Math.cos(angleAt(now, point) - angle)));
        dots([outline.reduce((best, point) => (off(point) < off(best) ? point : best))], colour);
      }
    }
  }
}

function buttonOf(words, answer, act) {
  const button = Object.assign(document.createElement('button'), { type: 'button', textContent: words });
  button.dataset.answer = answer;
  button.addEventListener('click', act);
  return button;
}
function detailsOf(text) {
  const details = document.createElement('details');
  details.append(
    Object.assign(document.createElement('summary'), { textContent: 'details' }),
    Object.assign(document.createElement('code'), { textContent: text }),
  );
  return details;
}

const GRAM = 9.80665e-3;  // weight of one gram [N]
// Formats a force with its sigma. Before contact is visible, the force that cannot be seen is
// stated in place of a sigma of 0.
function forceWords({ force, sigma, depth, isTouching, unseen }) {
  if (!isTouching && !(sigma > 0)) return `0 N, no touch is seen yet${unseen > 0 ? `: one below ${figure(unseen)} N would not be` : ''}`;
  return `${figure(force)} N ± ${figure(sigma)} N (${figure(force / GRAM)} g) at ${figure(1e3 * depth)} mm`;
}

// Draws force over depth: the points, and a band of one sigma around them.
function drawCurve(canvas, points) {
  const pen = canvas.getContext('2d'),
    { width, height } = canvas,
    tone = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);
  pen.clearRect(0, 0, width, height);
  const deepest = Math.max(1e-4, ...points.map((p) => p.depth)), most = Math.max(1e-2, ...points.map((p) => p.force + (p.sigma || 0)));
  const x = (depth) => 44 + ((width - 54) * depth) / deepest, y = (force) => height - 24 - ((height - 36) * force) / most;
  pen.font = '12px system-ui, sans-serif';
  pen.fillStyle = tone('--dim');
  pen.fillText(`${figure(most)} N`, 2, 12);
  pen.fillText(`${figure(1e3 * deepest)} mm`, width - 54, height - 6);
  pen.fillText('0', 32, height - 10);
  pen.globalAlpha = 0.25;
  for (const { depth, force, sigma, valid } of points) {
    pen.fillStyle = tone(valid ? '--fill' : '--force');
    pen.fillRect(x(depth) - 1, y(force + (sigma || 0)), 2, Math.max(1, y(force - (sigma || 0)) - y(force + (sigma || 0))));
  }
  pen.globalAlpha = 1;
  for (const { depth, force, valid } of points) {
    pen.fillStyle = tone(valid ? '--fill' : '--force');
    pen.fillRect(x(depth) - 1.5, y(force) - 1.5, 3, 3);
  }
}
