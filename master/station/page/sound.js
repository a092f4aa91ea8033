// The force as an optional tone: louder and higher with the force, silent without.

export class Sound {
  constructor() {
    this.button = document.getElementById('sound');
    this.button.addEventListener('click', () => this.toggle());
  }
  toggle() {
    this.on = !this.on;
    this.button.setAttribute('aria-pressed', String(this.on));
    if (this.on && !this.context) {
      this.context = new AudioContext();
      this.gain = new GainNode(this.context, { gain: 0 });
      this.tone = new OscillatorNode(this.context, { type: 'triangle', frequency: 110 });
      this.tone.connect(this.gain).connect(this.context.destination);
      this.tone.start();
    }
    if (!this.on) this.show(0);
  }
  // `share` of the force limit.
  show(share) {
    if (!this.context) return;
    const part = this.on ? Math.min(1, share) : 0;
    this.gain.gain.setTargetAtTime(0.12 * Math.sqrt(part), this.context.currentTime, 0.015);
    this.tone.frequency.setTargetAtTime(110 * 4 ** part, this.context.currentTime, 0.015);
  }
}
