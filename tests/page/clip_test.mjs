// What the page keeps for a shared file, without a browser.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Share } from '../../master/station/page/share.js';

const state = (t, { sequence = Math.round(1000 * t), force = t, validity = 'VALID', touching = true, operator = 'FOLLOWING', run } = {}) => ({
  t, state: operator, ...(run !== undefined && { replay: { run } }),
  slave_state: { sequence: String(sequence), force: { x: 0, y: force, z: 0 }, sigma: 0.05, validity: `VALIDITY_${validity}`, local_model: { in_contact: touching } },
});
// The topology of a square of four lines, and a shape of it whose upper corners are 2 mm lower.
function square(number) {
  const places = [0, 0, 0, 0.1, 0, 0, 0.1, 0.1, 0, 0, 0.1, 0], lines = [0, 1, 1, 2, 2, 3, 3, 0];
  const topology = new ArrayBuffer(28 + 4 * places.length + 4 * lines.length), view = new DataView(topology);
  [2, 4, 4].forEach((value, i) => view.setUint32(16 + 4 * i, value, true));
  new Float32Array(topology, 28, 12).set(places);
  new Uint32Array(topology, 76, 8).set(lines);
  const shape = new ArrayBuffer(20 + 4 * places.length);
  new Float32Array(shape, 20, 12).set(places.map((value, i) => (i === 7 || i === 10 ? value - 0.002 : value)));
  return { topology: { view, buffer: topology, number }, shape: { number, buffer: shape } };
}
const clipOf = (text) => JSON.parse(text.match(/<script type="application\/json" id="clip">([^]*?)<\/script>/)[1]);

test('the file holds the last minute: forces, sigma, validity, the outline and the scene in words', async () => {
  const share = new Share(), { topology, shape } = square(3);
  share.takeTopology(topology);
  for (let t = 0; t < 100; t += 0.05) {
    share.takeStatus(state(t));
    share.takeShape({ ...shape, t });
  }
  const text = await share.file({ name: 'a </script> b', geometry: 'rectangle', material: { young_modulus: 127e3, poisson_ratio: 0.49 }, model: { kind: 'bem2d' }, source: 'camera' }, 'a <b> press');
  const { states, shapes, words, mostMoved, body } = clipOf(text);
  assert.ok(Math.abs(states.at(-1).t - 60) < 0.11 && states[0].t >= 0 && states.length > 1190, `${states[0].t} to ${states.at(-1).t}`);
  for (const { sequence, force, sigma, validity } of states) assert.ok(Math.abs(force - Number(sequence) / 1000) < 1e-3 && sigma === 0.05 && validity === 'valid');
  assert.ok(shapes.length > 300 && shapes.length <= 485 && Math.abs(mostMoved - 0.002) < 1e-6, `${shapes.length} ${mostMoved}`);
  assert.deepEqual(body.lines, [[0, 1], [1, 2], [2, 3], [3, 0]]);
  assert.equal(words[0], 'Scene: a </script> b');
  assert.equal(text.match(/<\/script>/g).length, 2);
  assert.ok(text.includes('<title>a &lt;b> press</title>') && text.length < 8e6);
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
  // A shape of another mesh, and one that is cut, are left out.
  const { topology, shape } = square(3);
  share.takeTopology(topology);
  share.takeShape({ ...shape, number: 4, t: 2 });
  share.takeShape({ ...shape, buffer: shape.buffer.slice(0, 30), t: 2 });
  assert.equal(share.shapes.length, 0);
});
