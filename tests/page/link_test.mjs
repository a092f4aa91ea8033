// The page's connection and mapping, without a browser: a socket that records what the page sends.
import assert from 'node:assert/strict';
import { beforeEach, mock, test } from 'node:test';

import { Link } from '../../master/station/page/link.js';
import { mappingOf } from '../../master/station/page/scales.js';

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
  // Stops that were sent since the last call; their pings are answered where the master `takes` them.
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
  // A quarter turn about z: x of M is y of S.
  near(mappingOf(null, { operator: { orientation: [half, 0, 0, half] } }, first).rotation, [0, -1, 0, 1, 0, 0, 0, 0, 1]);
  near(mappingOf(null, { operator: { orientation: [half, half, 0, 0] } }, first).rotation, [1, 0, 0, 0, 0, -1, 0, 1, 0]);
  near(mappingOf(null, { operator: { orientation: [half, 0, half, 0] } }, first).rotation, [0, 0, 1, 0, 1, 0, -1, 0, 0]);
  near(mappingOf(null, null, first).rotation, first.rotation);
});
