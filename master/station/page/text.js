// Formats numbers and codes for a person.

// Writes only a changed text, because each write costs a layout.
export const write = (element, text) => {
  if (element.textContent !== text) element.textContent = text;
};
// Returns a value of an enumeration in state.proto without its prefix: `VALIDITY_STALE` is `stale`.
export const codeOf = (value, prefix) => (value || `${prefix}UNSPECIFIED`).slice(prefix.length).toLowerCase();
// Returns the numbers of a vector in state.proto.
export const xyz = (v) => [v.x, v.y, v.z];
export const norm = (v) => v && Math.hypot(v[0], v[1], v[2]);
export const fixed = (value, digits = 2) => (Number.isFinite(value) ? value.toFixed(digits) : '-');
// Formats to three significant digits, without an exponent if this is readable.
export const figure = (value) => {
  if (!Number.isFinite(value)) return '-';
  const size = Math.abs(value);
  if (size === 0) return '0';
  return size >= 1e5 || size < 1e-3 ? value.toExponential(1) : String(Number(value.toPrecision(3)));
};
// Formats a value and the half width (> 0) of its interval, both to the second significant digit of
// the half width.
export const interval = (value, half) => [value, half].map((number) => fixed(number, Math.max(0, 1 - Math.floor(Math.log10(half)))));
export const ms = (seconds, digits = 1) => (Number.isFinite(seconds) ? `${(seconds * 1e3).toFixed(digits)} ms` : '-');
// Formats an age [s]; null: nothing received. Negative ages get a special text.
export const LATER_S = 0.1;
export const ageWords = (age, isReplay) => {
  if (age === null) return '';
  if (age < -LATER_S) return isReplay ? 'of a later moment' : 'timestamp in the future: the clocks differ';
  return age > 1 ? `${age.toFixed(1)} s old` : `${Math.round(1e3 * Math.max(0, age))} ms old`;
};
// Formats a time as minutes and seconds.
export const minutes = (seconds, digits = 0) => {
  const whole = Number(seconds.toFixed(digits));
  return `${Math.floor(whole / 60)}:${(whole % 60).toFixed(digits).padStart(digits ? 3 + digits : 2, '0')}`;
};
// `unconnected` returns what the page is not connected to, from the messages `hello` and `status`
// and the reason of a lost master.
const STAND_INS = { 'sim-hand': 'a simulated operator leads', playback: 'a recorded motion leads', pointer: 'mouse, keys, touch or gamepad lead' };
export function unconnected(hello, status, lost) {
  if (lost) return ['master, so neither slave, tool nor device'];
  if (!hello) return [];
  if (hello.badge === 'REPLAY') return ['anything: this is a recording'];
  const observes = status?.link.observes, standIn = Object.keys(STAND_INS).find((name) => hello.device.startsWith(name));
  return [
    ...(status && !status.link.connected && !observes ? ['slave'] : []),
    ...(observes && !hello.only_observes ? ['manipulator: nobody can move the tool'] : []),
    ...(standIn && !observes ? [`haptic device: ${STAND_INS[standIn]}`] : []),
    ...(hello.simulated ? ['a real object: sensors and manipulator are simulated'] : []),
  ];
}
// Returns the unit of length that suits `size` [m].
export const lengthUnit = (size) => (size < 1e-4 ? { unit: 'µm', factor: 1e6 } : { unit: 'mm', factor: 1e3 });
// Returns the unit of stress that suits `size` [Pa].
export const stressUnit = (size) =>
  size >= 1e6 ? { unit: 'MPa', factor: 1e-6 } : size >= 1e3 ? { unit: 'kPa', factor: 1e-3 } : { unit: 'Pa', factor: 1 };

// For each reason of the force chain: the step at which it acts, and its text.
export const REASONS = {
  not_following: ['sent', 'not engaged'],
  stale: ['estimated', 'no state for 30 ms'],
  unknown: ['estimated', 'the slave does not know the force'],
  other_epoch: ['sent', 'the slave serves another engagement'],
  fading: ['sent', 'fading'],
  punctured: ['local', 'the tool broke through'],
  blending: ['local', 'blending two local models'],
  beyond_model: ['local', "beyond the model's range"],
  passivity: ['passive', 'damped by passivity control'],
  clamped: ['limited', 'force limit'],
  not_finite: ['limited', 'not a number'],
  bad_state: ['estimated', 'state with impossible numbers'],
  bad_device: ['sent', 'device reading with impossible numbers'],
  slewed: ['sent', 'slew limit'],
  projected: ['local', 'stiffness limited to a stable spring'],
  offset_jump: ['scaled', 'the slave moved the position offset'],
  settings: ['scaled', 'reading the settings'],
  aged: ['estimated', 'sample too old'],
  ended: ['estimated', "the slave's stream ended"],
  plane: ['local', 'outside the patch: plane'],
  held: ['local', 'newest received force'],
  arm_fault: ['estimated', "the manipulator's driver is silent or reports a fault"],
  tared: ['estimated', 'minus the tare'],
  fixture: ['scaled', 'lock, box, fixture or speed limit'],
};

// The stages of the end-to-end latency: key, name, short name.
export const TRACE = [
  ['capture', 'capture, until the slave has the sample', 'capture'],
  ['sensing', 'vision or tactile processing', 'vision'],
  ['model', 'model', 'model'],
  ['wait', 'until the state is sent', 'wait'],
  ['wire', 'network, by both clocks', 'network'],
  ['tick', 'until the haptic tick', 'tick'],
];

export const VALIDITY = {
  valid: ['ok', 'valid'], extrapolated: ['warn', 'extrapolated'], punctured: ['warn', 'punctured'], stale: ['bad', 'stale'],
  tracking_lost: ['bad', 'tracking lost'], failed: ['bad', 'unknown'],
};

// For each operator state: level and meaning.
export const STATES = {
  DISCONNECTED: ['bad', 'no states from the slave'],
  READY: ['idle', 'not engaged: engage to move the tool'],
  ALIGNING: ['idle', 'waiting for the slave to follow'],
  FOLLOWING: ['ok', 'the tool follows the device'],
  CLUTCHED: ['idle', 'disengaged: the tool is stopped'],
  HOLD: ['warn', 'the tool is stopped, the force fades'],
  ESTOP: ['bad', 'emergency stop, latched'],
  STOP_REQUESTED: ['bad', 'the slave has not confirmed the emergency stop: the tool may still move'],
};
