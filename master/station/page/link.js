// The connection to the master: one WebSocket, reopened when it closes. It carries the newest message of each kind.
// Commands are dropped while it is closed or busy. An emergency stop is not: it is repeated until the master shows it.

import { codeOf, xyz } from './text.js';

const REPORT_EVERY = 2;  // processed messages between two reports
const RETRY_MS = 500, PING_MS = 500, SILENT_MS = 300, LOOK_LATE_MS = 200, STOP_MS = 100;
const UNANSWERED_STOPS = 20;  // after so many unanswered stops the socket is replaced
const FAILED = 5;  // validity of shapes and fields without a solution of the model
export const TOPOLOGY = 1, IMAGE = 5, SHAPE = 6, FIELD_TOPOLOGY = 7, FIELD = 8;

// Converts a status with its tick (ForceTick of recording.proto) for the panels: vectors become
// lists, the forces become `chain`, and state and reasons lose the prefixes of their enumerations.
export function withTick(message) {
  if (!message.tick) return message;
  const { phase, reasons, ...fields } = message.tick;
  const tick = Object.fromEntries(Object.entries(fields).map(([name, value]) => [name, value?.x === undefined ? value : xyz(value)]));
  return {
    ...message,
    ...tick,
    state: codeOf(phase, 'OPERATOR_PHASE_').toUpperCase(),
    chain: { estimated: null, ...tick, reasons: reasons.map((reason) => codeOf(reason, 'FORCE_REASON_')) },
  };
}

// `receive(kind, message)` gets JSON objects by their `kind`, and for binary ones 'topology', 'image', 'shape' and, after
// send({do: 'field', on: true}) or in a replay, 'field_topology' and 'field', with {number, t, view: DataView, buffer}; `lost(reason)` when the
// connection closes or is silent, `found()` when it is back.
export class Link {
  constructor(receive, lost, found) {
    Object.assign(this, {
      receive,
      lost,
      found,
      delay: null,
      receivedAt: 0,
      watchedAt: 0,
      clock: null,
      silent: true,
      stopAskedAt: null,
      isStopTaken: false,
      answeredUntil: -1,
      unanswered: 0,
    });
    this.open();
    setInterval(() => this.watch(), 100);
    setInterval(() => this.send({ do: 'ping', at: performance.now() }), PING_MS);
    setInterval(() => this.repeatStop(), STOP_MS);
  }
  open() {
    this.unanswered = 0;
    this.isStopTaken = false;
    // The fragment of the address, which browsers do not send.
    const token = location.hash.slice(1);
    this.socket = new WebSocket(`${location.protocol.replace('http', 'ws')}//${location.host}/ws${token && `?token=${token}`}`);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onopen = () => this.repeatStop();
    let taken = 0;
    this.socket.onmessage = ({ data, target }) => {
      this.take(data);
      // This count lets the master send no more than the page can process.
      taken += 1;
      if (taken % REPORT_EVERY === 0 && target.readyState === WebSocket.OPEN) target.send(new Uint32Array([taken]));
    };
    this.socket.onclose = (event) => {
      this.reportLoss(
        event.reason ||
          (location.protocol === 'https:'
            ? 'palpate-master does not answer, or the token is wrong: open the address that it printed'
            : 'palpate-master does not answer'),
      );
      setTimeout(() => this.open(), RETRY_MS);
    };
  }
  reportLoss(reason) {
    this.silent = true;
    this.lost(reason);
  }
  watch() {
    // Messages of the busy time are not processed yet.
    const now = performance.now(), wasBusy = now - this.watchedAt > LOOK_LATE_MS;
    this.watchedAt = now;
    if (!wasBusy && !this.silent && now - this.receivedAt > SILENT_MS) this.reportLoss('palpate-master does not respond');
  }
  take(data) {
    this.receivedAt = performance.now();
    this.unanswered = 0;
    if (this.silent) {
      this.silent = false;
      this.found();
    }
    if (typeof data === 'string') return this.takeText(JSON.parse(data));
    const view = new DataView(data), topic = view.getUint32(0, true);
    const kind = {
      [TOPOLOGY]: 'topology',
      [IMAGE]: 'image',
      [SHAPE]: 'shape',
      [FIELD_TOPOLOGY]: 'field_topology',
      [FIELD]: 'field',
    }[topic];
    this.receive(kind, { number: view.getUint32(4, true), t: view.getFloat64(8, true), view, buffer: data });
  }
  takeText(text) {
    const message = withTick(text);
    if (message.kind === 'pong') {
      this.delay = performance.now() - message.at;
      this.answeredUntil = message.at;
      return;
    }
    if (message.kind === 'status') this.compareWithStop(message.state);
    if (message.kind === 'status')
      this.clock = { t: message.t, at: this.receivedAt, rate: message.replay ? message.replay.playing * message.replay.speed : 1 };
    this.receive(message.kind, message);
  }
  // Returns the present time of the session or recording [s]; null: unknown.
  now() {
    return this.clock && this.clock.t + (this.clock.rate * (performance.now() - this.clock.at)) / 1000;
  }
  send(command) {
    if (this.socket.readyState === WebSocket.OPEN && this.socket.bufferedAmount < 4096) this.socket.send(JSON.stringify(command));
  }
  // An emergency stop is repeated until the master has answered a later ping and shows the stop, and it is pending until the
  // slave's own state has answered it. A status of an earlier stop, which is being reset, confirms nothing.
  stop() {
    this.stopAskedAt = performance.now();
    this.isStopTaken = false;
    this.repeatStop();
  }
  get isStopPending() {
    return this.stopAskedAt !== null;
  }
  compareWithStop(state) {
    if (!this.isStopPending || this.answeredUntil < this.stopAskedAt) return;
    if (state === 'ESTOP' || (this.isStopTaken && state !== 'STOP_REQUESTED')) this.stopAskedAt = null;
    else if (state === 'STOP_REQUESTED') this.isStopTaken = true;
  }
  repeatStop() {
    if (!this.isStopPending || this.isStopTaken) return;
    this.unanswered += 1;
    if (this.unanswered > UNANSWERED_STOPS) this.replaceSocket();
    if (this.socket.readyState !== WebSocket.OPEN) return;
    for (const command of [{ do: 'stop' }, { do: 'ping', at: performance.now() }]) this.socket.send(JSON.stringify(command));
  }
  // On a silently cut link a browser may wait minutes for a handshake or an answer, so the socket
  // is replaced.
  replaceSocket() {
    const old = this.socket;
    Object.assign(old, { onopen: null, onmessage: null, onclose: null });
    old.close();
    this.reportLoss('palpate-master does not answer');
    this.open();
  }
  // Forgets a pending stop, because a replay has nothing to stop.
  forgetStop() {
    this.stopAskedAt = null;
  }
}

// Returns nodes and triangles of the displacement field: `rest` x, y, z per node in the object's
// frame O [m], and node indices, three per triangle, counter-clockwise seen from outside.
export function fieldTopologyOf({ number, view, buffer }) {
  const [nodes, triangles] = [16, 20].map((at) => view.getUint32(at, true)), end = 24 + 12 * nodes;
  return { number, rest: new Float32Array(buffer, 24, 3 * nodes), triangles: new Uint32Array(buffer, end, 3 * triangles) };
}

// Returns the displacement field at the time `t` of an image: `displacement` x, y, z per node in
// frame O [m], and the displaced position `image` u, v per node [px], u to the right, v down, (0,
// 0) at the centre of the upper left pixel, NaN behind the camera; null: the scene has no camera.
// Returns null if the field has another topology. `isSolved`: false if the model has no solution,
// so that the field is an old one.
export function fieldOf({ number, t, view, buffer }, topology) {
  const count = topology?.rest.length, hasImage = view.getUint32(20, true) === 1;
  if (number !== topology?.number || buffer.byteLength !== 24 + 4 * count + (hasImage ? (8 * count) / 3 : 0)) return null;
  return {
    t,
    isSolved: view.getUint32(16, true) !== FAILED,
    displacement: new Float32Array(buffer, 24, count),
    image: hasImage ? new Float32Array(buffer, 24 + 4 * count, (2 * count) / 3) : null,
  };
}
