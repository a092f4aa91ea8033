// Tests the data that the page stores for a shared file, without a browser.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Body } from '../../master/station/page/body.js';
import { drawField, visibleOf } from '../../master/station/page/field.js';
import { Share } from '../../master/station/page/share.js';

const state = (t, { sequence = Math.round(1000 * t), force = t, validity = 'VALID', touching = true, operator = 'FOLLOWING', run } = {}) => ({
  t, state: operator, ...(run !== undefined && { replay: { run } }),
  slave_state: { sequence: String(sequence), force: { x: 0, y: force, z: 0 }, sigma: 0.05, validity: `VALIDITY_${validity}`, local_model: { in_contact: touching } },
});
// Returns the field of a square of two triangles with a side of 100 px in the image, whose upper
// corners move down by `moved` [m].
const TOPOLOGY = { number: 3, rest: Float32Array.of(0, 0, 0, 0.1, 0, 0, 0.1, 0.1, 0, 0, 0.1, 0), triangles: Uint32Array.of(0, 1, 2, 0, 2, 3) };
const fieldAt = (t, moved) => ({
  t, number: 3, isSolved: true,
  displacement: Float32Array.of(0, 0, 0, 0, 0, 0, 0, -moved, 0, 0, -moved, 0), image: null,
});
const clipOf = (text) => JSON.parse(text.match(/<script type="application\/json" id="clip">([^]*?)<\/script>/)[1]);

test('the file holds the last minute: forces, sigma, validity, the field and the scene in words', async () => {
  const share = new Share();
  share.takeFieldTopology(TOPOLOGY);
  for (let t = 0; t < 100; t += 0.05) {
    share.takeStatus(state(t));
    share.takeField(fieldAt(t, t / 1e5));
  }
  const text = await share.file({ name: 'a </script> b', geometry: 'rectangle', material: { young_modulus: 127e3, poisson_ratio: 0.49 }, model: { kind: 'bem2d' }, source: 'camera' }, 'a <b> press');
  const { states, field, words } = clipOf(text);
  assert.ok(Math.abs(states.at(-1).t - 60) < 0.11 && states[0].t >= 0 && states.length > 1190, `${states[0].t} to ${states.at(-1).t}`);
  for (const { sequence, force, sigma, validity } of states) assert.ok(Math.abs(force - Number(sequence) / 1000) < 1e-3 && sigma === 0.05 && validity === 'valid');
  assert.ok(field.isPlanar && field.frames.length > 300 && field.frames.length <= 485 && Math.abs(field.full - 0.001) < 1e-6, `${field.frames.length} ${field.full}`);
  // One step of a value is a 255th of the largest displacement.
  const values = Buffer.from(field.frames.at(-1).values, 'base64');
  assert.deepEqual([...values], [0, 0, 255, 255]);
  assert.equal(words[0], 'Scene: a </script> b');
  assert.equal(text.match(/<\/script>/g).length, 2);
  assert.ok(text.includes('<title>a &lt;b> press</title>') && text.length < 8e6);
});

// Reference: the area of a square below a level is in proportion to it. Each band is filled from
// its level upwards, the last one on top.
test('bands of equal displacement cover what moves more than their level, and the lowest stays free', () => {
  const areas = [], pen = {
    beginPath() { this.polygons = []; },
    moveTo(x, y) { this.polygons.push([[x, y]]); },
    lineTo(x, y) { this.polygons.at(-1).push([x, y]); },
    closePath() {},
    fill() {
      const area = (points) => points.reduce((sum, [x, y], i) => sum + (x * points[(i + 1) % points.length][1] - points[(i + 1) % points.length][0] * y) / 2, 0);
      areas.push(this.polygons.reduce((sum, points) => sum + Math.abs(area(points)), 0));
    },
  };
  // The magnitude rises from 0 at the lower edge to 1 at the upper one.
  drawField(pen, TOPOLOGY.triangles, [0, 0, 1, 1], (node) => [1000 * TOPOLOGY.rest[3 * node], 1000 * TOPOLOGY.rest[3 * node + 1]]);
  assert.equal(areas.length, 11);
  areas.forEach((area, i) => assert.ok(Math.abs(area - 1e4 * (1 - (i + 1) / 12)) < 1e-6 * 1e4, `band ${i + 1}: ${area}`));
});

// Reference: the pose by which the outline was moved; single precision rounds by a relative 6e-8.
test("the pose of a planar body is that of its outline, whatever the inside does", () => {
  const [angle, shift] = [0.3, [0.02, -0.05]], outline = [[0, 0], [0.1, 0], [0.1, 0.08], [0, 0.06]];
  const turned = ([x, y]) => [Math.cos(angle) * x - Math.sin(angle) * y + shift[0], Math.sin(angle) * x + Math.cos(angle) * y + shift[1]];
  const flat = (points) => Float32Array.from(points.flatMap(([x, y]) => [x, y, 0]));
  const [[cos, sin], [right, up]] = Body.prototype.poseOf.call({ places: flat(outline.map(turned)), nodes: 4 }, flat([...outline, [9, 9]]));
  [[cos, Math.cos(angle)], [sin, Math.sin(angle)], [right, shift[0]], [up, shift[1]]].forEach(([found, wanted]) => assert.ok(Math.abs(found - wanted) < 1e-6, `${found} ${wanted}`));
});

test('triangles that face away are left out, and of a planar body none', () => {
  const image = Float32Array.of(0, 100, 100, 100, 100, 0, 0, 0);  // v points down
  assert.deepEqual([...visibleOf([0, 1, 2, 0, 3, 2], image, false)], [0, 1, 2]);
  assert.deepEqual([...visibleOf([0, 1, 2, 0, 3, 2], image, true)], [0, 1, 2, 0, 3, 2]);
});

test('a state without a force has no sigma', async () => {
  const share = new Share();
  share.takeStatus(state(0));
  const unknown = state(1, { validity: 'STALE' });
  delete unknown.slave_state.force;
  unknown.slave_state.sigma = 0;
  share.takeStatus(unknown);
  const { states } = clipOf(await share.file(null, 'x'));
  assert.deepEqual(states.map(({ force, sigma }) => [force, sigma]), [[0, 0.05], [null, null]]);
});

test('the moment of a time is the newest before it, and nothing where it is long ago', () => {
  const share = new Share();
  share.takeFieldTopology(TOPOLOGY);
  for (const t of [1, 2, 3]) share.takeField(fieldAt(t, 0.001));
  share.takeStatus(state(2.2));
  const { field, status, image } = share.momentAt(2.4);
  assert.deepEqual([field.t, status.t, image], [2, 2.2, null]);
  assert.equal(share.momentAt(9).field, null);
});

test('contact, release, flags and stops are events; a flag that flutters is one', () => {
  const share = new Share();
  const take = (t, options) => share.takeStatus(state(t, options));
  take(0, { touching: false });
  take(1);
  for (let i = 0; i < 8; ++i) take(2 + 0.1 * i, { validity: i % 2 ? 'STALE' : 'VALID' });
  take(3, { operator: 'ESTOP' });
  take(4, { operator: 'ESTOP', touching: false });
  assert.deepEqual(share.events.map(({ name }) => name), ['contact', 'stale', 'stop', 'release']);
});

test('without states there is no file, and a jump of a replay empties it', async () => {
  const share = new Share();
  assert.equal(await share.file(null, 'x'), null);
  share.takeStatus(state(50, { run: 1 }));
  share.takeStatus(state(2, { run: 2 }));
  assert.deepEqual(share.states.map(({ t }) => t), [2]);
});
