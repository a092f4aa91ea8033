// Tests the page's connection and mapping without a browser: a fake socket records what the page
// sends.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { beforeEach, mock, test } from 'node:test';

import { FIELD, FIELD_TOPOLOGY, Link, fieldOf, fieldTopologyOf, withTick } from '../../master/station/page/link.js';
import { BeatGap, Pointer } from '../../master/station/page/pointer.js';
import { mappingOf } from '../../master/station/page/scales.js';
import { REASONS, STATES, VALIDITY } from '../../master/station/page/text.js';

let sockets = [];
class Socket {
  static OPEN = 1;
  constructor() {
    Object.assign(this, { readyState: 0, bufferedAmount: 0, sent: [] });
    sockets.push(this);
  }
  send(text) {
    this.sent.push(JSON.parse(text));
  }
  open() {
    this.readyState = Socket.OPEN;
    this.onopen?.();
  }
  close() {
    this.readyState = 3;
    this.onclose?.({ reason: '' });
  }
  hear(message) {
    this.onmessage({ data: JSON.stringify(message), target: this });
  }
  // Returns the stops that were sent since the last call. If the master `takes` them, their pings
  // are answered.
  stops(takes = false) {
    const sent = this.sent.splice(0);
    if (takes) for (const { do: what, at } of sent) if (what === 'ping') this.hear({ kind: 'pong', at });
    return sent.filter(({ do: what }) => what === 'stop').length;
  }
}

let link, socket;
beforeEach(() => {
  mock.timers.reset();
  mock.timers.enable({ apis: ['setInterval', 'setTimeout'] });
  Object.assign(globalThis, { WebSocket: Socket, location: { hash: '', protocol: 'http:', host: 'master' } });
  sockets = [];
  link = new Link(() => {}, () => {}, () => {});
  [socket] = sockets;
});
const status = (state) => ({ kind: 'status', t: 0, state });

test('a stop that is pressed while the page is not connected is sent when the socket opens', () => {
  link.stop();
  assert.equal(socket.stops(), 0);
  socket.open();
  assert.equal(socket.stops(), 1);
});

test('a stop is repeated, also on the next socket, until a status shows it', () => {
  socket.open();
  link.stop();
  assert.equal(socket.stops(), 1);
  mock.timers.tick(300);
  assert.ok(socket.stops() >= 2, 'it is repeated');
  socket.close();
  mock.timers.tick(500);
  assert.equal(sockets.length, 2);
  const next = sockets[1];
  next.open();
  assert.equal(next.stops(true), 1);
  next.hear(status('FOLLOWING'));
  assert.ok(link.isStopPending);
  next.hear(status('ESTOP'));
  assert.ok(!link.isStopPending);
  mock.timers.tick(1000);
  assert.equal(next.stops(), 0);
});

test('a pending stop does not wait for a socket that never opens or never answers', () => {
  link.stop();
  mock.timers.tick(2500);
  assert.equal(sockets.length, 2, 'no handshake for 2 s');
  assert.equal(socket.readyState, 3, 'browsers open one socket at a time');
  const next = sockets[1];
  next.open();
  assert.ok(next.stops() > 0);
  mock.timers.tick(2500);
  assert.equal(sockets.length, 3, 'no answer for 2 s');
  const last = sockets[2];
  last.open();
  last.stops(true);
  last.hear(status('ESTOP'));
  assert.ok(!link.isStopPending);
  mock.timers.tick(5000);
  assert.equal(sockets.length, 3);
});

test('a stop passes a full buffer, which drops other commands', () => {
  socket.open();
  socket.bufferedAmount = 4096;
  link.send({ do: 'mark' });
  link.stop();
  const { sent } = socket;
  assert.ok(!sent.some(({ do: what }) => what === 'mark') && sent.some(({ do: what }) => what === 'stop'), JSON.stringify(sent));
});

test('a stop that the master has taken is not sent again, and stays pending until the slave answers', () => {
  socket.open();
  link.stop();
  socket.stops(true);
  socket.hear(status('STOP_REQUESTED'));
  socket.stops();
  mock.timers.tick(1000);
  assert.equal(socket.stops(), 0);
  assert.ok(link.isStopPending, 'the line to the slave is cut');
  socket.hear(status('READY'));
  assert.ok(!link.isStopPending, 'another operator has reset it');
});

test('a status of the stop before, which is being reset, does not confirm a new stop', () => {
  socket.open();
  socket.hear(status('ESTOP'));
  link.send({ do: 'reset' });
  link.stop();
  socket.hear(status('ESTOP'));
  assert.ok(link.isStopPending);
  socket.stops(true);
  socket.hear(status('READY'));
  assert.ok(link.isStopPending);
  mock.timers.tick(200);
  assert.ok(socket.stops(true) > 0);
  socket.hear(status('ESTOP'));
  assert.ok(!link.isStopPending);
});

test("the pointer is turned by the orientation of the slave's present scene", () => {
  const half = Math.sqrt(0.5), first = { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1] };
  const near = (a, b) => a.forEach((part, i) => assert.ok(Math.abs(part - b[i]) < 1e-12, `${a}`));
  // Rotation by 90 degrees about z: x of M is y of S.
  near(mappingOf(null, { operator: { orientation: [half, 0, 0, half] } }, first).rotation, [0, -1, 0, 1, 0, 0, 0, 0, 1]);
  near(mappingOf(null, { operator: { orientation: [half, half, 0, 0] } }, first).rotation, [1, 0, 0, 0, 0, -1, 0, 1, 0]);
  near(mappingOf(null, { operator: { orientation: [half, 0, half, 0] } }, first).rotation, [0, 0, 1, 0, 1, 0, -1, 0, 0]);
  near(mappingOf(null, null, first).rotation, first.rotation);
});

test('the longest gap of the timer is remembered for 5 to 10 s, without the time of a hidden page', () => {
  const gap = new BeatGap();
  let now = 1000;
  const beat = (after) => gap.take((now += after));
  const longest = () => Math.round(1000 * gap.longest);
  for (let i = 0; i < 100; ++i) beat(20);
  assert.equal(longest(), 20);
  beat(400);
  const end = now;
  while (now < end + 4900) beat(20);
  assert.equal(longest(), 400);
  while (now < end + 10100) beat(20);
  assert.equal(longest(), 20);
  gap.skip();
  beat(60000);
  beat(20);
  assert.equal(longest(), 20);
});

// The first statuses after the silence may be from its beginning.
test('a page that was silent lets go and says for how long it was silent', () => {
  const pointer = { engaged: true, heldSince: 1, silence: null, release() { this.engaged = false; } };
  const take = (holds, silence) => Pointer.prototype.releaseIfHeld.call(pointer, { pointer_holds: holds, pointer_used: 2, pointer_silence: silence });
  assert.equal(take(true, 0), null);
  assert.match(take(false, 0.26), /^The page was silent for 260 ms, so the operator was disengaged/);
  assert.ok(!pointer.engaged);
  assert.match(take(false, 1.5), /^The page was silent for 1500 ms/);
  assert.equal(take(false, 1.5), null, 'it is said once');
  pointer.engaged = true;
  assert.equal(take(false, 1.5), null, 'pressed again');
  assert.equal(take(true, 0), null);
  assert.ok(pointer.engaged);
});

// Returns the names of an enumeration's values without their prefix, as in the messages.
function namesOf(file, name) {
  const text = readFileSync(new URL(`../../proto/palpate/v1/${file}.proto`, import.meta.url), 'utf8');
  const [, body] = text.match(new RegExp(`^enum ${name} \\{([^}]*)\\}`, 'm'));
  const [first, ...values] = [...body.matchAll(/^\s*([A-Z_]+) = \d+;/gm)].map(([, value]) => value);
  return values.map((value) => value.slice(first.length - 'UNSPECIFIED'.length));
}

test('there are words for each value of an enumeration, and for no other', () => {
  const lower = (names) => names.map((value) => value.toLowerCase()).sort();
  assert.deepEqual(Object.keys(STATES).sort(), namesOf('recording', 'OperatorPhase').sort());
  assert.deepEqual(Object.keys(REASONS).sort(), lower(namesOf('recording', 'ForceReason')));
  assert.deepEqual(Object.keys(VALIDITY).sort(), lower(namesOf('state', 'Validity')));
});

test('a tick is read by the names of its message', () => {
  const tick = { phase: 'OPERATOR_PHASE_HOLD', reasons: ['FORCE_REASON_BEYOND_MODEL'], p_M: { x: 1, y: 2, z: 3 }, sent: { x: 0, y: 4, z: 0 }, marks: 2 };
  const read = withTick({ kind: 'status', t: 5, tick });
  assert.equal(read.state, 'HOLD');
  assert.deepEqual(read.p_M, [1, 2, 3]);
  assert.deepEqual(read.chain.sent, [0, 4, 0]);
  assert.deepEqual(read.chain.reasons, ['beyond_model']);
  assert.equal(read.chain.estimated, null, 'not known');
  assert.equal(read.marks, 2);
  assert.equal(read.t, 5);
});

test('a displacement field is read with its topology, and not with another', () => {
  let kind, message;
  link = new Link((...received) => ([kind, message] = received), () => {}, () => {});
  const header = (topic, number) => {
    const bytes = new DataView(new ArrayBuffer(16));
    bytes.setUint32(0, topic, true);
    bytes.setUint32(4, number, true);
    bytes.setFloat64(8, 2.5, true);
    return [...new Uint8Array(bytes.buffer)];
  };
  const take = (head, integers, floats, more = []) => {
    const tail = [new Uint32Array(integers), new Float32Array(floats), new Uint32Array(more)].flatMap((list) => [...new Uint8Array(list.buffer)]);
    link.take(new Uint8Array([...head, ...tail]).buffer);
  };
  take(header(FIELD_TOPOLOGY, 7), [3, 1], [0, 0, 0, 1, 0, 0, 0, 1, 0], [0, 1, 2]);
  assert.equal(kind, 'field_topology');
  const topology = fieldTopologyOf(message);
  assert.deepEqual([...topology.rest], [0, 0, 0, 1, 0, 0, 0, 1, 0]);
  assert.deepEqual([...topology.triangles], [0, 1, 2]);
  take(header(FIELD, 7), [0, 1], [0, 0.25, 0, 0, 0, 0, 0, 0, 0, 10, 20, 30, 20, 10, 0]);
  assert.equal(kind, 'field');
  const field = fieldOf(message, topology);
  assert.equal(field.t, 2.5);
  assert.equal(field.isSolved, true);
  assert.equal(field.displacement[1], 0.25);
  assert.deepEqual([...field.image], [10, 20, 30, 20, 10, 0]);
  assert.equal(fieldOf(message, { ...topology, number: 6 }), null);
  take(header(FIELD, 7), [5, 0], [0, 0, 0, 0, 0, 0, 0, 0, 0]);
  assert.equal(fieldOf(message, topology).image, null, 'no camera');
  assert.equal(fieldOf(message, topology).isSolved, false);
});
