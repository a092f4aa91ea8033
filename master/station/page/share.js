// One press as one HTML file that replays it without a server: the images, the outline as computed, force with sigma and validity, and
// the scene in words. The page keeps the last minute for it.
import { save } from './save.js';
import { playClip } from './share_player.js';
import { codeOf, figure, xyz } from './words.js';

const SECONDS = 60, AGAIN_S = 1, IMAGES_HZ = 8, SHAPES_HZ = 8, WIDEST_PX = 480, QUALITY = 0.6;
const BYTES_PER_S = 8e6 / 60, SPARE = 3e4;  // of the file; of its text
const PLACES_AT = 20, HEAD = 28;  // of a shape's and a topology's bytes

export class Share {
  constructor() {
    this.begin();
  }
  // Another session, or another part of a recording.
  begin() {
    Object.assign(this, { images: [], shapes: [], states: [], events: [], body: null, run: undefined });
  }
  // Forgets what is older than a minute. Not each time, because that moves the whole list.
  trim(list, t) {
    if (list.length && t - list[0].t > 1.2 * SECONDS) list.splice(0, list.findIndex((item) => t - item.t <= SECONDS));
  }
  isDue(list, t, rate) {
    return Number.isFinite(t) && !(list.length && t - list.at(-1).t < 0.98 / rate && t >= list.at(-1).t);
  }
  takeImage({ t, buffer }) {
    if (!this.isDue(this.images, t, IMAGES_HZ)) return;
    this.images.push({ t, bytes: new Uint8Array(buffer, 16) });
    this.trim(this.images, t);
  }
  // Outlines alone: the surface of a volume does not fit into such a file.
  takeTopology({ view, buffer, number }) {
    const [perElement, nodes, elements] = [16, 20, 24].map((at) => view.getUint32(at, true));
    this.shapes = [];
    this.body = null;
    if (perElement !== 2) return;
    const index = new Uint32Array(buffer.slice(HEAD + 12 * nodes, HEAD + 12 * nodes + 8 * elements));
    this.body = {
      number,
      nodes,
      rest: planar(new Float32Array(buffer.slice(HEAD, HEAD + 12 * nodes))),
      lines: Array.from({ length: elements }, (_, i) => [index[2 * i], index[2 * i + 1]]),
    };
  }
  takeShape({ t, number, buffer }) {
    const { body } = this;
    if (number !== body?.number || buffer.byteLength < PLACES_AT + 12 * body.nodes || !this.isDue(this.shapes, t, SHAPES_HZ)) return;
    this.shapes.push({ t, places: planar(new Float32Array(buffer.slice(PLACES_AT, PLACES_AT + 12 * body.nodes))) });
    this.trim(this.shapes, t);
  }
  takeStatus({ t, state, replay, slave_state: slave }) {
    if (replay?.run !== this.run) {
      const { body } = this;
      this.begin();
      Object.assign(this, { body, run: replay?.run });
    }
    if (!slave || slave.sequence === this.states.at(-1)?.sequence) return;
    const before = this.states.at(-1), isTouching = Boolean(slave.local_model?.in_contact), validity = codeOf(slave.validity, 'VALIDITY_');
    this.states.push({
      t,
      sequence: slave.sequence,
      force: slave.force ? Math.hypot(...xyz(slave.force)) : null,
      sigma: slave.sigma ?? null,
      validity,
      isTouching,
      state,
    });
    if (before && isTouching !== before.isTouching) this.mark(t, isTouching ? 'contact' : 'release');
    if (before && validity !== before.validity && validity !== 'valid') this.mark(t, validity.replaceAll('_', ' '));
    if (before && state === 'ESTOP' && before.state !== 'ESTOP') this.mark(t, 'stop');
    for (const list of [this.states, this.events]) this.trim(list, t);
  }

  // One line for what happens again and again.
  mark(t, name) {
    const last = this.events.findLast((event) => event.name === name);
    if (!last || t - last.t > AGAIN_S) this.events.push({ t, name });
  }

  // The file as text. `scene`: of the health message, or null.
  async file(scene, title) {
    if (!this.states.length) return null;
    const end = this.states.at(-1).t,
      from = Math.max(this.states[0].t, end - SECONDS),
      during = (list) => list.filter(({ t }) => t >= from && t <= end).map((item) => ({ ...item, t: Number((item.t - from).toFixed(4)) }));
    const shapes = during(this.shapes).map(({ t, places }) => ({ t, places: places.map((value) => Number(value.toFixed(6))) })),
      { body } = this;
    const moved = ({ places }) => Math.max(...places.map((value, i) => Math.abs(value - body.rest[i])));
    const clip = {
      title,
      words: wordsOf(scene),
      states: during(this.states).map(({ isTouching, state, sequence, ...kept }) => ({ ...kept, sequence: String(sequence) })),
      events: during(this.events),
      shapes,
      images: [],
      mostMoved: Math.max(1e-6, ...shapes.map(moved)),
      body: body && { rest: [...body.rest], lines: body.lines, box: boxOf(body.rest) },
    };
    const text = pageOf(clip), room = BYTES_PER_S * Math.max(1, end - from) - text.length - SPARE;
    clip.images = await within(during(this.images), room);
    return pageOf(clip);
  }
  async save(scene, title) {
    const text = await this.file(scene, title);
    if (text) save(new Blob([text], { type: 'text/html' }), `${title.replace(/[^\w-]+/g, '-')}.html`);
    return Boolean(text);
  }
}

const planar = (places) => Array.from({ length: (2 * places.length) / 3 }, (_, i) => places[3 * Math.floor(i / 2) + (i % 2)]);
const boxOf = (rest) =>
  [0, 1, 0, 1].map((k, i) =>
    rest.filter((_, j) => j % 2 === k).reduce((best, value) => (i < 2 ? Math.min(best, value) : Math.max(best, value))),
  );

function wordsOf(scene) {
  if (!scene) return [];
  const { material = {}, model = {} } = scene;
  return [
    `Scene: ${scene.name}`,
    `Object: ${scene.geometry}`,
    `Young's modulus: ${figure(material.young_modulus / 1e3)} kPa, Poisson's ratio ${figure(material.poisson_ratio)}`,
    `Model: ${model.kind}`,
    `Sensing: ${scene.source}`,
  ];
}

// As many images, small enough, as fit into `room` [bytes].
async function within(images, room) {
  const small = [];
  for (const { t, bytes } of images) {
    const jpeg = await shrunk(bytes).catch(() => null);
    if (jpeg) small.push({ t, jpeg });
  }
  const total = small.reduce((sum, { jpeg }) => sum + jpeg.length + 40, 0), every = Math.max(1, Math.ceil(total / Math.max(1, room)));
  return small.filter((_, i) => i % every === 0);
}
async function shrunk(bytes) {
  const bitmap = await createImageBitmap(new Blob([bytes], { type: 'image/jpeg' })), scale = Math.min(1, WIDEST_PX / bitmap.width);
  const canvas = new OffscreenCanvas(Math.round(scale * bitmap.width), Math.round(scale * bitmap.height));
  canvas.getContext('2d').drawImage(bitmap, 0, 0, canvas.width, canvas.height);
  const blob = await canvas.convertToBlob({ type: 'image/jpeg', quality: QUALITY }), letters = new Uint8Array(await blob.arrayBuffer());
  return btoa(Array.from(letters, (byte) => String.fromCharCode(byte)).join(''));
}

const STYLE = `body{margin:0 auto;max-width:1000px;padding:16px;font:16px/1.4 system-ui,sans-serif;color:#14202b;background:#fff}
.views{display:flex;flex-wrap:wrap;gap:12px}.views img,.views canvas{max-width:100%;border:1px solid #d3dae1;border-radius:8px}
#curve{width:100%;border:1px solid #d3dae1;border-radius:8px}#force{font-size:22px;font-weight:650}#force[data-valid=false]{color:#7a4b00}
.bar{display:flex;gap:12px;margin:10px 0}#place{flex:1}button{min-width:90px;min-height:36px;font:inherit}`;
// Text of a script element cannot end it.
const inScript = (text) => text.replaceAll('<', '\\u003c');
function pageOf(clip) {
  return `<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy"
  content="default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'">
<title>${clip.title.replaceAll('&', '&amp;').replaceAll('<', '&lt;')}</title><style>${STYLE}</style></head>
<body><main><h1 id="title"></h1><p id="force" role="status"></p>
<div class="views"><img id="picture" alt="Camera image"><canvas id="field" width="400" height="360" role="img"
  aria-label="The object as computed, in the colours of its displacement"></canvas></div>
<div class="bar"><button id="play" type="button">Play</button><input id="place" type="range" aria-label="Time in the press, seconds"></div>
<canvas id="curve" width="960" height="300" role="img"
  aria-label="Force over time, in newtons and seconds, with one standard deviation"></canvas>
<ul id="words"></ul><p>Recorded with Palpate. This file loads nothing from the network.</p></main>
<script type="application/json" id="clip">${inScript(JSON.stringify(clip))}</script>
<script>(${String(playClip)})(JSON.parse(document.getElementById('clip').textContent));</script></body></html>
`;
}
