// Operates a slave: lease, clutch, watchdog, and motions of the tool in frame S.
'use strict';

const grpc = require('@grpc/grpc-js');
const {PalpateError, translated} = require('./errors');
const {State, timestamp, vec3, vector} = require('./state');

/** @typedef {import('./state').Vector} Vector */
/** @typedef {import('../messages/palpate/v1/SceneDescription').SceneDescription__Output} Scene */
/** @typedef {import('../messages/palpate/v1/Teleoperation').TeleoperationClient} Client */

const PERIOD = 4;      // [ms] between commands; the slave holds the tool after 30 ms of silence
const HELD = 1000;     // [ms] for which the tool may not follow before a motion is rejected
const ANSWER = 10000;  // [ms] for the first state and for an engagement

/** @param {Readonly<Vector>} a @param {Readonly<Vector>} b @returns {Vector} */
const sum = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
/** @param {Readonly<Vector>} a @param {number} scale @returns {Vector} */
const times = (a, scale) => [scale * a[0], scale * a[1], scale * a[2]];

/**
 * Holds the lease of a slave until `close`, and moves its tool. `Slave.operate` makes it.
 *
 * A timer sends the newest target every 4 ms. A motion advances only while states arrive and the tool follows. So a lost
 * link, a held tool or an emergency stop pause it and never make the tool jump. If the program ends or its event loop
 * hangs, the tool holds its position.
 */
class Operator {
  /** @param {Client} client @param {Scene} scene @param {string} name */
  constructor(client, scene, name) {
    const mapping = scene.operator;
    if (!mapping) throw new Error('the scene has no mapping of the operator');
    this._name = name;
    this._scale = mapping.position_scale;
    this._rotation = mapping.rotation;
    this._silence = 1000 * (mapping.dead_after || 0.030);
    this._revision = scene.settings_revision;
    this._sequence = 0;
    this._epoch = 0;
    this._engaged = false;
    /** @type {Vector | null} Tip at the engagement. */
    this._offset = null;
    /** @type {Vector} From there: at present, and at the end. */
    this._moved = [0, 0, 0];
    /** @type {Vector} */
    this._goal = [0, 0, 0];
    this._speed = 0;
    this._heard = 0;
    this._last = performance.now();
    /** @type {State[]} Since the last motion began. */
    this._states = [];
    /** @type {Error | null} */
    this._error = null;
    this._closing = false;
    const metadata = new grpc.Metadata();
    metadata.set('palpate-operator-bin', Buffer.from(name));
    this._stream = client.Operate(metadata);
    this._stream.on('data', (message) => {
      this._states.push(new State(message));
      this._heard = performance.now();
    });
    this._stream.on('error', () => {});  // `status` reports it
    /** @type {Promise<void>} */
    this._ended = new Promise((resolve) => {
      this._stream.on('status', (status) => {
        clearInterval(this._timer);
        this._error = status.code === grpc.status.OK ? new PalpateError('OK', 'the slave ended the stream') : translated(status);
        resolve();
      });
    });
    this._timer = setInterval(() => this._send(), PERIOD);
  }

  /** The newest state. */
  get state() { return this._states[this._states.length - 1]; }

  /** Commanded tool tip [m]; before the first engagement the measured one. */
  get position() { return this._offset ? sum(this._offset, this._moved) : this.state.tip; }

  /** Closes the clutch: from now on the tool follows. It does not move by this. */
  async engage() {
    ++this._epoch;
    this._engaged = true;
    this._offset = null;
    this._moved = this._goal = [0, 0, 0];
    await this._until(() => this._isFollowing(), ANSWER, 'the slave does not follow');
    this._offset = vector(this.state.message.offset);
  }

  /** Opens the clutch: the tool is stationary. */
  release() { this._engaged = false; }

  /**
   * Moves the commanded tip in a straight line. Engages if needed. Resolves to the states received meanwhile.
   * @param {Readonly<Vector>} tip [m] @param {number} speed [m/s]
   */
  async moveTo(tip, speed) {
    if (!tip.every(Number.isFinite) || !(speed > 0 && speed < Infinity)) {
      throw new RangeError(`tip ${tip} m, speed ${speed} m/s: accepted are finite numbers, and a speed > 0`);
    }
    if (!this._engaged || !this._offset) await this.engage();
    const offset = /** @type {Vector} */ (this._offset);
    this._goal = sum(tip, times(offset, -1));
    this._speed = speed;
    this._states.splice(0, this._states.length - 1);
    let held = performance.now();
    try {
      await this._until(() => {
        if (this._isAlive()) held = performance.now();
        if (performance.now() - held > HELD) throw new PalpateError('INTERRUPTED', `the tool does not follow: ${this.state.message.phase}`);
        return this._moved === this._goal;
      }, Infinity, '');
    } finally {
      this._goal = this._moved;  // an interrupted motion does not go on by itself
    }
    return [...this._states];
  }

  /** The same by `step` [m]. @param {Readonly<Vector>} step @param {number} speed [m/s] */
  async moveBy(step, speed) {
    if (!this._engaged || !this._offset) await this.engage();
    return this.moveTo(sum(this.position, step), speed);
  }

  /** Stays. Resolves to the states received meanwhile. @param {number} seconds */
  async hold(seconds) {
    this._states.splice(0, this._states.length - 1);
    const end = performance.now() + 1000 * seconds;
    await this._until(() => performance.now() > end, Infinity, '');
    return [...this._states];
  }

  /** Opens the clutch and returns the lease. */
  async close() {
    this._closing = true;
    this._engaged = false;
    clearInterval(this._timer);
    if (!this._error) {
      this._send();
      this._stream.end();
    }
    await this._ended;
  }

  /** Waits for the first state. */
  async _begin() {
    await this._until(() => true, ANSWER, 'no state arrived');
    return this;
  }

  _isFollowing() {
    const {epoch, phase} = this.state.message;
    return this._engaged && epoch === this._epoch && phase === 'PHASE_FOLLOWING';
  }

  /** The tool follows, and states arrive. */
  _isAlive() { return this._offset && this._isFollowing() && performance.now() - this._heard < this._silence; }

  /** @param {() => boolean} condition @param {number} patience [ms] @param {string} otherwise */
  async _until(condition, patience, otherwise) {
    const end = performance.now() + patience;
    while (this._states.length === 0 || !condition()) {
      if (this._error) throw this._error;
      if (performance.now() > end) throw new PalpateError('INTERRUPTED', otherwise);
      await new Promise((resolve) => setTimeout(resolve, PERIOD));
    }
  }

  _send() {
    const now = performance.now(), dt = Math.min((now - this._last) / 1000, 0.02);  // a stalled machine makes no step
    this._last = now;
    const left = sum(this._goal, times(this._moved, -1));
    const distance = Math.hypot(...left);
    /** @type {Vector} */
    let velocity = [0, 0, 0];
    if (this._moved !== this._goal && this._states.length > 0 && this._isAlive()) {
      if (distance > 0) velocity = times(left, this._speed / distance);
      this._moved = distance <= this._speed * dt ? this._goal : sum(this._moved, times(velocity, dt));
    }
    const newest = this._states.length > 0 ? this.state.message : null;
    this._stream.write({
      sequence: ++this._sequence, sent_at: timestamp(), epoch: this._epoch, engaged: this._engaged, settings_revision: this._revision,
      p_M: vec3(this._toDevice(this._moved)), velocity: vec3(this._toDevice(velocity)),
      operator_name: this._sequence === 1 ? this._name : '',
      state_sequence: newest ? newest.sequence : 0, echo: newest ? newest.sent_at : null,
    });
  }

  /** From frame S to the device's frame M. @param {Vector} v @returns {Vector} */
  _toDevice(v) {
    const row = (/** @type {number} */ i) => (this._rotation[i] * v[0] + this._rotation[3 + i] * v[1] + this._rotation[6 + i] * v[2]) / this._scale;
    return [row(0), row(1), row(2)];
  }
}

module.exports = {Operator};
