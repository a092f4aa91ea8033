// Tests contact as sound without a browser: a fake audio context records the requested tones.
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';

let played, kept, listeners, button;
class Param {
  setTargetAtTime(value) { this.value = value; }
}
class Oscillator {
  constructor(context, { frequency }) {
    this.frequency = Object.assign(new Param(), { value: frequency });
  }
  connect(next) { return next; }
  start() { played.push(this); }
  stop() { this.isNote = true; }
}
class Gain {
  constructor() {
    this.gain = new Param();
    played.gains.push(this.gain);
  }
  connect(next) { return next; }
}
Object.assign(globalThis, { AudioContext: class { currentTime = 0; }, OscillatorNode: Oscillator, GainNode: Gain });
globalThis.localStorage = { getItem: (name) => kept[name] ?? null, setItem: (name, value) => { kept[name] = value; } };
globalThis.window = { addEventListener: (name, act) => { listeners[name] = act; } };
globalThis.document = { getElementById: () => button };
const { Sound } = await import('../../master/station/page/sound.js');

beforeEach(() => {
  [played, kept, listeners] = [Object.assign([], { gains: [] }), {}, {}];
  button = { addEventListener: (name, act) => { button.press = act; }, setAttribute: (name, value) => { button[name] = value; } };
});
const notes = () => played.filter(({ isNote }) => isNote).map(({ frequency }) => frequency.value);
const loudness = () => played.gains[0].value;

test('a contact is heard without a setting: a note at its begin, a lower one at its end, and a tone that grows with the force', () => {
  const sound = new Sound();
  listeners.keydown();  // browsers play nothing before a key or click
  sound.show(0, false);
  assert.deepEqual([notes(), loudness()], [[], 0]);
  sound.show(0.01, true);
  const soft = loudness();
  sound.show(0.9, true);
  assert.ok(soft > 0 && loudness() > soft, `${soft}, ${loudness()}`);
  sound.show(0, false);
  assert.equal(loudness(), 0);
  const [begin, end] = notes();
  assert.ok(notes().length === 2 && begin > end, notes().join());
});

test('switched off it is silent, and stays so after the page is loaded again', () => {
  let sound = new Sound();
  listeners.keydown();
  sound.show(0.5, true);
  button.press();
  assert.equal(button['aria-pressed'], 'false');
  for (const isTouching of [false, true]) sound.show(0.5, isTouching);
  assert.deepEqual([notes().length, loudness()], [1, 0]);
  played.splice(0);
  sound = new Sound();
  listeners.keydown();
  sound.show(0.5, true);
  assert.equal(played.length, 0);
});
