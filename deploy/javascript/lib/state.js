// A state of the slave. SI units, frame S. Numbers that are unknown are NaN.
'use strict';

/** @typedef {import('../messages/palpate/v1/SlaveState').SlaveState__Output} SlaveState */
/** @typedef {[number, number, number]} Vector */
/** @typedef {{x: number, y: number, z: number}} Vec3 */

/** @type {Vector} */
const UNKNOWN = [NaN, NaN, NaN];

/** @param {Vec3 | null} message @returns {Vector} */
const vector = (message) => message ? [message.x, message.y, message.z] : [NaN, NaN, NaN];

/** @param {Readonly<Vector>} v @returns {Vec3} */
const vec3 = ([x, y, z]) => ({x, y, z});

/** This machine's time, or `ms` since 1970. @param {number} [ms] */
function timestamp(ms = performance.timeOrigin + performance.now()) {
  const seconds = Math.floor(ms / 1000);
  return {seconds, nanos: Math.floor((ms - 1000 * seconds) * 1e6)};
}

/** The estimate at one instant. */
class State {
  /** @param {SlaveState} message */
  constructor(message) {
    /** Everything that the slave sent. */
    this.message = message;
  }

  get sequence() { return this.message.sequence; }

  /** Time of the image or tactile sample, slave's clock [s since 1970]. The force belongs to it. */
  get t() {
    const sensed = this.message.sensed_at;
    return sensed ? Number(sensed.seconds) + 1e-9 * sensed.nanos : NaN;
  }

  /** Measured tool tip [m]. */
  get tip() { return vector(this.message.p_S_tip); }

  /** Force of the object on the tool [N]. Use it as a measurement only if `valid`. */
  get force() { return this.known ? vector(this.message.force) : UNKNOWN; }

  /** One standard deviation of the force [N]. */
  get sigma() { return this.known ? this.message.sigma : NaN; }

  /** There is a force. A stale state repeats the last one, which may not hold any more. */
  get known() { return this.message.force !== null && this.message.validity !== 'VALIDITY_STALE'; }

  /** The force is a measurement: all checks pass and the model is within its range. */
  get valid() { return this.message.validity === 'VALIDITY_VALID'; }
}

module.exports = {State, timestamp, vec3, vector};
