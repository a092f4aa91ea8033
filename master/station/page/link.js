// The line to the master: one WebSocket, opened again when it ends. What comes is the newest of each kind.

const RETRY_MS = 500, PING_MS = 500, SILENT_MS = 300;
export const TOPOLOGY = 1, PICTURE = 5, SHAPE = 6;

// `hear(kind, message)` gets JSON objects by their `kind`, and for binary ones 'topology', 'picture', 'shape' with
// {number, t, data: DataView, bytes: Uint8Array}; `lost(reason)` when the line ends or is silent, `found()` when it is back.
export class Link {
  constructor(hear, lost, found) {
    Object.assign(this, { hear, lost, found, delay: null, heardAt: 0, clock: null, silent: true });
    this.open();
    setInterval(() => this.watch(), 100);
    setInterval(() => this.send({ do: 'ping', at: performance.now() }), PING_MS);
  }
  open() {
    this.socket = new WebSocket(`ws://${location.host}/ws`);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onmessage = (event) => this.take(event.data);
    this.socket.onclose = (event) => {
      this.tellLost(event.reason || 'no line to palpate-master');
      setTimeout(() => this.open(), RETRY_MS);
    };
  }
  tellLost(reason) {
    this.silent = true;
    this.lost(reason);
  }
  watch() {
    if (!this.silent && performance.now() - this.heardAt > SILENT_MS) this.tellLost('palpate-master is silent');
  }
  take(data) {
    this.heardAt = performance.now();
    if (this.silent) {
      this.silent = false;
      this.found();
    }
    if (typeof data === 'string') return this.takeText(JSON.parse(data));
    const view = new DataView(data), topic = view.getUint32(0, true);
    const kind = { [TOPOLOGY]: 'topology', [PICTURE]: 'picture', [SHAPE]: 'shape' }[topic];
    this.hear(kind, { number: view.getUint32(4, true), t: view.getFloat64(8, true), view, buffer: data });
  }
  takeText(message) {
    if (message.kind === 'pong') {
      this.delay = performance.now() - message.at;
      return;
    }
    if (message.kind === 'status') this.clock = { t: message.t, at: this.heardAt };
    this.hear(message.kind, message);
  }
  // Seconds since the session began, now; null: not known.
  now() {
    return this.clock && this.clock.t + (performance.now() - this.clock.at) / 1000;
  }
  send(wish) {
    if (this.socket.readyState === WebSocket.OPEN && this.socket.bufferedAmount < 4096) this.socket.send(JSON.stringify(wish));
  }
}
