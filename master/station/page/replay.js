// Controls of a replay: position and speed. They never move a tool.
import { minutes } from './text.js';

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
const STEP_S = 1, LEAP_S = 10;

const byId = (id) => document.getElementById(id);

export class ReplayBar {
  constructor(link) {
    Object.assign(this, { link, active: false, now: null, t: 0 });
    byId('play').addEventListener('click', () => this.toggle());
    byId('place').addEventListener('input', () => this.go(byId('place').valueAsNumber));
    byId('speed').replaceChildren(...SPEEDS.map((speed) => new Option(`${speed}x`, speed)));
    byId('speed').addEventListener('change', () => this.pace(Number(byId('speed').value)));
    byId('replay').addEventListener('submit', (event) => event.preventDefault());
  }
  enable(yes) {
    this.active = yes;
    byId('replay').hidden = !yes;
    document.body.classList.toggle('replay', yes);
  }
  show(status) {
    const { replay, t } = status;
    if (!replay) return;
    [this.now, this.t] = [replay, t];
    const place = byId('place'), text = `${minutes(t, 1)} of ${minutes(replay.seconds, 1)}`;
    place.max = replay.seconds.toFixed(2);
    if (!place.matches(':active')) place.value = t;
    place.setAttribute('aria-valuetext', text);
    byId('time').textContent = text;
    byId('play').firstChild.textContent = replay.playing ? 'Pause ' : 'Play ';
    if (document.activeElement !== byId('speed')) byId('speed').value = replay.speed;
  }
  toggle() {
    this.link.send({ do: 'replay', playing: !this.now?.playing });
  }
  go(t) {
    this.t = Math.min(Math.max(t, 0), this.now?.seconds || 0);
    this.link.send({ do: 'replay', to: this.t });
  }
  pace(speed) {
    this.link.send({ do: 'replay', speed });
  }
  // Changes to the next higher (sign 1) or lower (-1) speed.
  change(sign) {
    const faster = SPEEDS.filter((speed) => sign * (speed - this.now.speed) > 1e-9);
    if (faster.length) this.pace(sign > 0 ? faster[0] : faster.at(-1));
  }
  key(event) {
    if (!this.active || !this.now || event.ctrlKey || event.metaKey || event.altKey) return false;
    const far = event.shiftKey ? LEAP_S : STEP_S;
    const act = {
      ' ': () => this.toggle(),
      k: () => this.toggle(),
      ArrowLeft: () => this.go(this.t - far),
      ArrowRight: () => this.go(this.t + far),
      Home: () => this.go(0),
      End: () => this.go(this.now.seconds),
      '[': () => this.change(-1),
      ']': () => this.change(1),
    }[event.key];
    if (!act || event.target.closest('[role=tablist], select')) return false;
    act();
    return true;
  }
}
