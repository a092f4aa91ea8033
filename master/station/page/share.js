// Stores the last minute of received data: for the time cursor of the charts, and as one HTML file
// that replays it without a server, with images, displacement of the model, force with sigma and
// validity, and the scene in words.
import { STOPS, niceAbove, viridis } from './colours.js';
import { drawField, magnitudesOf, visibleOf } from './field.js';
import { save } from './save.js';
import { playClip } from './share_player.js';
import { codeOf, figure, xyz } from './text.js';

const SECONDS = 60, AGAIN_S = 1, VIEWS_HZ = 8, WIDEST_PX = 480, QUALITY = 0.6;
// Size of the file per second; bytes for its text; margin of the image size.
const BYTES_PER_S = 8e6 / 60, SPARE = 3e4, MARGIN = 1.1;
// Cosine of the smallest angle between two triangles at a sharp edge.
const SHARP = Math.cos(Math.PI / 6);
// Largest time between views of one moment; a recording has eight per second.
const TOGETHER_S = 0.5;
// Steps of positions from -0.5 to 1.5 of the image's width, and of values up to full colour.
const PLACE_STEPS = 65535, VALUE_STEPS = 255;
// View from a corner for bodies without a camera: its right and up directions.
const ASIDE = [Math.sqrt(0.5), Math.sqrt(0.5), 0], UPWARDS = [-Math.sqrt(1 / 6), Math.sqrt(1 / 6), Math.sqrt(2 / 3)];

export class Share {
  constructor() {
    this.topology = null;
    this.begin();
  }
  // Starts another session or another part of a recording. Topologies are received when they
  // change.
  begin(run) {
    Object.assign(this, { images: [], shapes: [], fields: [], statuses: [], states: [], events: [], run });
  }
  // Removes data older than a minute, but not on each call, because that moves the whole list.
  trim(list, t) {
    if (list.length && t - list[0].t > 1.2 * SECONDS) list.splice(0, list.findIndex((item) => t - item.t <= SECONDS));
  }
  keep(list, item) {
    const { t } = item, last = list.at(-1)?.t;
    if (!Number.isFinite(t) || (t >= last && t - last < 0.98 / VIEWS_HZ)) return;
    list.push(item);
    this.trim(list, t);
  }
  takeImage(message) {
    this.keep(this.images, message);
  }
  takeShape(message) {
    this.keep(this.shapes, message);
  }
  takeFieldTopology(topology) {
    Object.assign(this, { topology, fields: [] });
  }
  takeField(field) {
    this.keep(this.fields, field);
  }
  takeStatus(message) {
    const { t, state, replay, slave_state: slave } = message;
    if (replay?.run !== this.run) this.begin(replay?.run);
    this.keep(this.statuses, { ...message, samples: [] });
    if (!slave || slave.sequence === this.states.at(-1)?.sequence) return;
    const before = this.states.at(-1), isTouching = Boolean(slave.local_model?.in_contact), validity = codeOf(slave.validity, 'VALIDITY_');
    const isKnown = Boolean(slave.force);
    this.states.push({
      t,
      sequence: slave.sequence,
      force: isKnown ? Math.hypot(...xyz(slave.force)) : null,
      sigma: isKnown ? slave.sigma : null,
      validity,
      isTouching,
      state,
    });
    if (before && isTouching !== before.isTouching) this.mark(t, isTouching ? 'contact' : 'release');
    if (before && validity !== before.validity && validity !== 'valid') this.mark(t, validity.replaceAll('_', ' '));
    if (before && state === 'ESTOP' && before.state !== 'ESTOP') this.mark(t, 'stop');
    for (const list of [this.states, this.events]) this.trim(list, t);
  }
  // Marks a repeated event only once.
  mark(t, name) {
    const last = this.events.findLast((event) => event.name === name);
    if (!last || t - last.t > AGAIN_S) this.events.push({ t, name });
  }
  // Returns the data that were shown at the time `t`; parts may be missing.
  momentAt(t) {
    const newest = (list) => {
      const item = list.findLast((one) => one.t <= t + 1e-9);
      return item && t - item.t < TOGETHER_S ? item : null;
    };
    return { image: newest(this.images), shape: newest(this.shapes), field: newest(this.fields), status: newest(this.statuses) };
  }

  // Returns the file as text. `scene`: of the health message, or null.
  async file(scene, title) {
    if (!this.states.length) return null;
    const end = this.states.at(-1).t, from = Math.max(this.states[0].t, end - SECONDS);
    const during = (list) => list.filter(({ t }) => t >= from && t <= end), since = (t) => Number((t - from).toFixed(4));
    const images = during(this.images), width = images.length ? await widthOf(images[0]) : null;
    const clip = {
      title,
      words: wordsOf(scene),
      states: during(this.states).map(({ t, sequence, force, sigma, validity }) => ({
        t: since(t),
        sequence: String(sequence),
        force,
        sigma,
        validity,
      })),
      events: during(this.events).map(({ t, name }) => ({ t: since(t), name })),
      field: this.topology && packedFields(this.topology, during(this.fields), width, since),
      images: [],
    };
    const room = BYTES_PER_S * Math.max(1, end - from) - pageOf(clip).length - SPARE;
    clip.images = await within(images, room, since);
    return pageOf(clip);
  }
  async save(scene, title) {
    const text = await this.file(scene, title);
    if (text) save(new Blob([text], { type: 'text/html' }), `${title.replace(/[^\w-]+/g, '-')}.html`);
    return Boolean(text);
  }
}

const base64Of = (bytes) => btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(''));
const range = (list) => list.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);

// Returns the fields as text: {triangles, edges, full [m], isPlanar, frames: [{t, places,
// values}]}, in base64: `places` two bytes for u and two for v per node, `values` one byte per
// node. Without an image of `width` px the body is drawn from a corner. Null: nothing to draw.
function packedFields({ rest, triangles }, fields, width, since) {
  if (!fields.length || (width && !fields[0].image)) return null;
  const largest = fields.map(({ displacement }) => magnitudesOf(displacement).reduce((most, value) => Math.max(most, value), 0));
  const full = niceAbove(Math.max(1e-9, ...largest)), fromCorner = cornerView(rest);
  const placesOf = ({ image, displacement }) => (width ? image.map((value) => (value + 0.5) / width) : fromCorner(displacement));
  const stepOf = (part) => Math.round((Math.min(1.5, Math.max(-0.5, part)) + 0.5) * (PLACE_STEPS / 2));
  return {
    triangles: [...triangles],
    edges: width ? [] : sharpEdges(rest, triangles),
    full,
    isPlanar: rest.every((value, i) => i % 3 < 2 || value === 0),
    frames: fields.map((field) => ({
      t: since(field.t),
      places: base64Of(new Uint8Array(Uint16Array.from(placesOf(field), stepOf).buffer)),
      values: base64Of(magnitudesOf(field.displacement).map((value) => Math.round((VALUE_STEPS * value) / full))),
    })),
  };
}
// Returns pairs of nodes at sharp edges and boundaries of the surface.
function sharpEdges(rest, triangles) {
  const open = new Map(), edges = [], at = (node, axis) => rest[3 * node + axis];
  for (let i = 0; i < triangles.length; i += 3) {
    const [a, b, c] = triangles.slice(i, i + 3), [p, q] = [b, c].map((node) => [0, 1, 2].map((axis) => at(node, axis) - at(a, axis)));
    const normal = [0, 1, 2].map((k) => p[(k + 1) % 3] * q[(k + 2) % 3] - p[(k + 2) % 3] * q[(k + 1) % 3]), size = Math.hypot(...normal);
    const unit = normal.map((part) => part / size);
    for (const [from, to] of [[a, b], [b, c], [c, a]]) {
      const other = open.get(`${to} ${from}`);
      if (!other) open.set(`${from} ${to}`, unit);
      else if (other.reduce((sum, part, k) => sum + part * unit[k], 0) < SHARP) edges.push([from, to]);
      open.delete(`${to} ${from}`);
    }
  }
  return [...edges, ...[...open.keys()].map((key) => key.split(' ').map(Number))].flat();
}
// Returns positions u, v of the displaced nodes in an image of the body with sides 4 : 3 [relative
// to its width], centred on the body.
function cornerView(rest) {
  const along = (displacement, way, i) => [0, 1, 2].reduce((sum, k) => sum + way[k] * (rest[i + k] + displacement[i + k]), 0);
  const places = (displacement) =>
    Float32Array.from({ length: (2 * rest.length) / 3 }, (_, j) =>
      j % 2 ? -along(displacement, UPWARDS, 3 * (j >> 1)) : along(displacement, ASIDE, 3 * (j >> 1)),
    );
  const still = places(new Float32Array(rest.length)), [columns, rows] = [0, 1].map((k) => range(still.filter((_, j) => j % 2 === k)));
  const side = 1.15 * Math.max(columns[1] - columns[0], (4 / 3) * (rows[1] - rows[0])), middle = [columns, rows].map(([low, high]) => (low + high) / 2);
  return (displacement) => places(displacement).map((value, j) => 0.5 + (value - middle[j % 2]) / side);
}

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

const bitmapOf = ({ buffer }) => createImageBitmap(new Blob([new Uint8Array(buffer, 16)], { type: 'image/jpeg' }));
const widthOf = (image) => bitmapOf(image).then(({ width }) => width).catch(() => null);
// Returns as many images as fit into `room` [bytes], reduced in size; the size is estimated from
// the middle one.
async function within(images, room, since) {
  const sample = images.length ? await shrunk(images[images.length >> 1]).catch(() => '') : '';
  const every = Math.max(1, Math.ceil((MARGIN * images.length * sample.length) / Math.max(1, room))), small = [];
  let left = room;
  for (const image of images.filter((_, i) => i % every === 0)) {
    const jpeg = await shrunk(image).catch(() => null);
    left -= (jpeg?.length ?? 0) + 40;
    if (jpeg && left > 0) small.push({ t: since(image.t), jpeg });
  }
  return small;
}
async function shrunk(image) {
  const bitmap = await bitmapOf(image), scale = Math.min(1, WIDEST_PX / bitmap.width);
  const canvas = new OffscreenCanvas(Math.round(scale * bitmap.width), Math.round(scale * bitmap.height));
  canvas.getContext('2d').drawImage(bitmap, 0, 0, canvas.width, canvas.height);
  const blob = await canvas.convertToBlob({ type: 'image/jpeg', quality: QUALITY });
  return base64Of(new Uint8Array(await blob.arrayBuffer()));
}

const STYLE = `body{margin:0 auto;max-width:960px;padding:16px;font:16px/1.45 system-ui,sans-serif;color:#14202b;background:#fff}
h1{margin:0 0 4px;font-size:24px}#force{margin:0 0 8px;font-size:22px;font-weight:650;font-variant-numeric:tabular-nums}
#force[data-valid=false]{color:#7a4b00}.views{position:relative}
#view{display:block;width:100%;border:1px solid #d3dae1;border-radius:8px;background:#f4f6f8}
#bar{position:absolute;left:10px;bottom:10px;display:flex;align-items:center;gap:7px;padding:4px 10px;border-radius:7px;background:#fffd;font-size:14px}
#bar i{width:110px;height:13px;border:1px solid #8795a3;border-radius:3px}
#curve{display:block;width:100%;border:1px solid #d3dae1;border-radius:8px}
.time{display:flex;gap:12px;margin:10px 0}#place{flex:1;min-width:0}button{min-width:96px;min-height:40px;font:inherit}
:focus-visible{outline:3px solid #1668b8;outline-offset:2px}`;
// Escapes text so that it cannot end a script element.
const inScript = (text) => text.replaceAll('<', '\\u003c');
const program = () =>
  `const STOPS = ${JSON.stringify(STOPS)};\n${[viridis, visibleOf, drawField, playClip].map(String).join('\n')}\n` +
  `playClip(JSON.parse(document.getElementById('clip').textContent));`;
function pageOf(clip) {
  return `<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy"
  content="default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'">
<title>${clip.title.replaceAll('&', '&amp;').replaceAll('<', '&lt;')}</title><style>${STYLE}</style></head>
<body><main><h1 id="title"></h1><p id="force" role="status"></p>
<div class="views"><canvas id="view" width="960" height="720" role="img"
  aria-label="Camera image with the displacement of the model in colours"></canvas>
<div id="bar"><span>displacement</span><b>0</b><i></i><b></b></div></div>
<div class="time"><button id="play" type="button">Play</button><input id="place" type="range" aria-label="Time in the press, seconds"></div>
<canvas id="curve" width="960" height="300" role="img"
  aria-label="Force over time, in newtons and seconds, with one standard deviation"></canvas>
<ul id="words"></ul><p>Recorded with Palpate. This file loads nothing from the network.</p></main>
<script type="application/json" id="clip">${inScript(JSON.stringify(clip))}</script>
<script>${program()}</script></body></html>
`;
}
