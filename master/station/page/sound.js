// Plays contact as sound unless it is switched off: a note when contact begins, a lower one when it
// ends, and between them a tone that is louder and higher with the force. Browsers play nothing
// before the first key or click.
import { keep, kept } from './save.js';

const BEGIN_HZ = 660, END_HZ = 330, NOTE_S = 0.09, NOTE_GAIN = 0.1;
const MIN_GAIN = 0.02, GAIN = 0.12, LOWEST_HZ = 110, SMOOTH_S = 0.015;

export class Sound {
  constructor() {
    this.isOn = kept('sound') !== 'off';
    this.isTouching = false;
    this.button = document.getElementById('sound');
    this.button.addEventListener('click', () => this.toggle());
    this.button.setAttribute('aria-pressed', String(this.isOn));
    for (const first of ['keydown', 'pointerup']) window.addEventListener(first, () => this.isOn && this.begin(), { once: true });
  }
  begin() {
    if (this.context) return;
    this.context = new AudioContext();
    this.gain = new GainNode(this.context, { gain: 0 });
    this.tone = new OscillatorNode(this.context, { type: 'triangle', frequency: LOWEST_HZ });
    this.tone.connect(this.gain).connect(this.context.destination);
    this.tone.start();
  }
  toggle() {
    this.isOn = !this.isOn;
    keep('sound', this.isOn ? 'on' : 'off');
    this.button.setAttribute('aria-pressed', String(this.isOn));
    if (this.isOn) this.begin();
    else this.show(0, false);
  }
  // `share`: force relative to its limit.
  show(share, isTouching) {
    if (this.context && this.isOn && isTouching !== this.isTouching) this.note(isTouching ? BEGIN_HZ : END_HZ);
    this.isTouching = isTouching;
    if (!this.context) return;
    const part = Math.min(1, share), isHeard = this.isOn && (isTouching || part > 0);
    this.gain.gain.setTargetAtTime(isHeard ? MIN_GAIN + (GAIN - MIN_GAIN) * Math.sqrt(part) : 0, this.context.currentTime, SMOOTH_S);
    this.tone.frequency.setTargetAtTime(LOWEST_HZ * 4 ** part, this.context.currentTime, SMOOTH_S);
  }
  note(frequency) {
    const { context } = this, end = context.currentTime + NOTE_S;
    const note = new OscillatorNode(context, { frequency }), gain = new GainNode(context, { gain: NOTE_GAIN });
    gain.gain.setTargetAtTime(0, end - NOTE_S / 2, NOTE_S / 6);
    note.connect(gain).connect(context.destination);
    note.start();
    note.stop(end);
  }
}
