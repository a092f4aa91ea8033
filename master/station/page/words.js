// Numbers and codes as a person reads them.

// What stands there already is not written again: that would cost a layout.
export const write = (element, text) => {
  if (element.textContent !== text) element.textContent = text;
};
export const norm = (v) => v && Math.hypot(v[0], v[1], v[2]);
export const fixed = (value, digits = 2) => (Number.isFinite(value) ? value.toFixed(digits) : '-');
// Three significant digits, without an exponent where it can be read without.
export const figure = (value) => {
  if (!Number.isFinite(value)) return '-';
  const size = Math.abs(value);
  if (size === 0) return '0';
  return size >= 1e5 || size < 1e-3 ? value.toExponential(1) : String(Number(value.toPrecision(3)));
};
export const ms = (seconds, digits = 1) => (Number.isFinite(seconds) ? `${(seconds * 1e3).toFixed(digits)} ms` : '-');
// How long ago it was [s]; null: nothing came. What a recording shows of a later moment, and stamps ahead of our clock, say so.
export const LATER_S = 0.1;
export const ageWords = (age, isReplay) => {
  if (age === null) return '';
  if (age < -LATER_S) return isReplay ? 'of a later moment' : 'stamped ahead: the clocks differ';
  return age > 1 ? `${age.toFixed(1)} s old` : `${Math.round(1e3 * Math.max(0, age))} ms old`;
};
// A time as minutes and seconds.
export const minutes = (seconds, digits = 0) => {
  const whole = Number(seconds.toFixed(digits));
  return `${Math.floor(whole / 60)}:${(whole % 60).toFixed(digits).padStart(digits ? 3 + digits : 2, '0')}`;
};
// A length with the unit that suits `size` [m].
export const lengthUnit = (size) => (size < 1e-4 ? { unit: 'µm', factor: 1e6 } : { unit: 'mm', factor: 1e3 });
// A stress with the unit that suits `size` [Pa].
export const stressUnit = (size) => (size >= 1e6 ? { unit: 'MPa', factor: 1e-6 } : size >= 1e3 ? { unit: 'kPa', factor: 1e-3 } : { unit: 'Pa', factor: 1 });

// What a reason of the force chain says, and at which station it acts.
export const REASONS = {
  not_following: ['sent', 'nobody follows'], stale: ['estimated', 'no state for 30 ms'], unknown: ['estimated', 'the slave does not know it'],
  other_epoch: ['sent', 'the slave serves another engagement'], fading: ['sent', 'fading'], punctured: ['local', 'the tool broke through'],
  blending: ['local', 'between two models'], beyond_model: ['local', "beyond the model's range"], passivity: ['passive', 'damped: no energy from nowhere'],
  clamped: ['limited', 'the force limit'], not_finite: ['limited', 'was no number'], bad_state: ['estimated', 'a state with impossible numbers'],
  bad_device: ['sent', 'a device reading with impossible numbers'], slewed: ['sent', 'cannot change faster'],
  projected: ['local', 'stiffness made a spring that can be shown'], offset_jump: ['scaled', 'the slave moved the offset'],
  settings: ['scaled', 'settings are being read'], aged: ['estimated', 'sensed too long ago'], ended: ['estimated', "the slave's stream ended"],
  plane: ['local', 'off the patch: the plane'], held: ['local', 'the newest force held'], arm_fault: ['estimated', "the slave's arm does not move"],
  tared: ['estimated', 'less the zero that was taken'],
};

// The stages from the photon to the hand: name, and for where there is little room.
export const TRACE = [['capture', 'camera or sensor, until the slave has it', 'capture'], ['eyes', 'eyes or fingertips', 'eyes'], ['model', 'model', 'model'],
  ['wait', 'until the state leaves', 'wait'], ['wire', 'wire, by the clocks', 'wire'], ['tick', 'until the tick', 'tick']];

export const VALIDITY = {
  valid: ['ok', 'valid'], extrapolated: ['warn', 'extrapolated'], punctured: ['warn', 'punctured'], stale: ['bad', 'stale'],
  tracking_lost: ['bad', 'tracking lost'], failed: ['bad', 'unknown'],
};

// Operator state: how serious, and what it means for the hand.
export const STATES = {
  DISCONNECTED: ['bad', 'no states from the slave'], READY: ['idle', 'nobody holds: take hold'], ALIGNING: ['idle', 'the slave takes up the hand'],
  FOLLOWING: ['ok', 'the tool follows the hand'], CLUTCHED: ['idle', 'let go: the tool stands'], HOLD: ['warn', 'the tool stands, the force fades'],
  ESTOP: ['bad', 'emergency stop, latched'],
};
