// The pointer device. A drag on the object, keys or a gamepad set its target. It disengages when
// the button, the focus, the window or the connection is lost.

// Period of reports while the pointer is held, and the smallest interval between two reports; time
// after which another client counts as the operator, or the pointer as idle; half of the time for
// which a late timer is remembered.
const REPORT_MS = 20, MIN_MS = 8, ELSEWHERE_MS = 500, HALF_MS = 5000;
// Speeds of an arrow key and of a stick [px/s]; dead zone of a stick.
const KEY_SPEED = 60, PAD_SPEED = 120, PAD_SLACK = 0.15;
const MOVES = {
  ArrowLeft: [-1, 0, 0],
  ArrowRight: [1, 0, 0],
  ArrowUp: [0, -1, 0],
  ArrowDown: [0, 1, 0],
  PageUp: [0, 0, 1],
  PageDown: [0, 0, -1],
};

// Measures how late the browser runs the page's timer. The master tolerates as much silence, within
// limits.
export class BeatGap {
  constructor() {
    Object.assign(this, { last: null, since: 0, newer: 0, older: 0 });
  }
  // `now` [ms]: time of a beat.
  take(now) {
    if (this.last !== null) this.newer = Math.max(this.newer, now - this.last);
    this.last = now;
    if (now - this.since > HALF_MS) Object.assign(this, { since: now, older: this.newer, newer: 0 });
  }
  // Leaves out the present gap. Browsers slow down the timers of a hidden page.
  skip() {
    this.last = null;
  }
  // The longest time between two beats in the last 5 to 10 s [s].
  get longest() {
    return Math.max(this.newer, this.older) / 1000;
  }
}

export class Pointer {
  constructor(link, view, mapping) {
    Object.assign(this, {
      link,
      view,
      mapping,
      enabled: false,
      button: false,
      held: false,
      padHeld: false,
      shift: false,
      p: [0, 0, 0],
      keys: new Set(),
      fingers: new Map(),  // touches on the view: id -> [x, y]
      locked: new Set(),
      gap: new BeatGap(),
      silence: null,  // that ended the last engagement [s]
      delay: null,
      sent: null,
      sentAt: 0,
      heldElsewhereSince: null,
      isLedElsewhere: false,
      idleSince: null,
      isIdle: false,
    });
    this.host = view.host;
    this.clutch = document.getElementById('clutch');
    this.clutch.addEventListener('click', () => this.toggle());
    for (const button of document.querySelectorAll('.locks button'))
      button.addEventListener('click', () => this.lock(Number(button.dataset.axis)));
    this.host.addEventListener('pointerdown', (event) => this.down(event));
    this.host.addEventListener('pointermove', (event) => this.move(event));
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) this.host.addEventListener(end, (event) => this.up(event));
    this.host.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
    this.host.addEventListener('contextmenu', (event) => event.preventDefault());
    window.addEventListener('blur', () => this.release());
    document.addEventListener('visibilitychange', () => {
      this.gap.skip();
      if (document.hidden) this.release();
    });
    window.addEventListener('pagehide', () => this.release());
    setInterval(() => this.beat(), REPORT_MS);
  }
  enable(yes) {
    this.enabled = yes;
    this.clutch.hidden = !yes;
    document.body.classList.toggle('with-pointer', yes);
  }
  get engaged() {
    return this.enabled && (this.button || this.held || this.padHeld) && !this.shift;
  }
  down(event) {
    this.host.focus();
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (this.fingers.size > 1) return this.letGo();  // two fingers zoom
    this.last = [event.clientX, event.clientY];
    this.turning = event.button !== 0 || !this.enabled;
    this.host.setPointerCapture(event.pointerId);
    if (this.turning) return;
    this.shift = event.shiftKey;
    this.button = true;
    this.heldSince = performance.now();
    this.tell();
  }
  move(event) {
    if (this.fingers.size > 1) return this.pinch(event);
    if (!this.last) return;
    const dx = event.clientX - this.last[0], dy = event.clientY - this.last[1];
    this.last = [event.clientX, event.clientY];
    if (this.turning) return this.view.turn(dx, dy);
    this.shift = event.shiftKey;
    if (this.engaged) this.lead(event.altKey ? this.view.drag(0, 0, -dy) : this.view.drag(dx, dy));
    else if (this.wasEngaged) this.tell();
  }
  pinch({ pointerId, clientX, clientY }) {
    const apart = () => {
      const [a, b] = [...this.fingers.values()];
      return Math.hypot(a[0] - b[0], a[1] - b[1]) || 1;
    };
    const before = apart();
    this.fingers.set(pointerId, [clientX, clientY]);
    this.view.zoom(before / apart());
  }
  up(event) {
    this.fingers.delete(event.pointerId);
    this.letGo();
  }
  letGo() {
    this.last = null;
    this.turning = false;
    if (!this.button) return;
    this.button = false;
    this.tell();
  }
  wheel(event) {
    event.preventDefault();
    if (this.engaged) this.lead(this.view.drag(0, 0, -event.deltaY / 4));
    else this.view.zoom(event.deltaY > 0 ? 1.1 : 1 / 1.1);
  }
  // Like `go`, but sends at once, because a busy page gets cursor events earlier than timer events.
  // The next timer event sends the rest.
  lead(move) {
    this.go(move);
    if (performance.now() - this.sentAt >= MIN_MS) this.tell();
  }
  // Moves the device so that the tool moves by `move_S` [m]: p_M = R^T p_S / scale.
  go(move) {
    const { rotation: R, position_scale: scale } = this.mapping();
    move = move.map((part, axis) => (this.locked.has(axis) ? 0 : part));
    for (let i = 0; i < 3; ++i) this.p[i] += (R[i] * move[0] + R[3 + i] * move[1] + R[6 + i] * move[2]) / scale;
  }
  // Locks or unlocks x, y or z of the target, frame S.
  lock(axis) {
    if (!this.locked.delete(axis)) this.locked.add(axis);
    for (const button of document.querySelectorAll('.locks button'))
      button.setAttribute('aria-pressed', String(this.locked.has(Number(button.dataset.axis))));
  }
  toggle() {
    if (!this.enabled) return;
    this.held = !this.held;
    this.heldSince = performance.now();
    this.tell();
  }
  release() {
    if (!this.enabled) return;
    this.button = this.held = false;
    this.last = null;
    this.keys.clear();
    this.fingers.clear();
    this.tell();
  }
  key(event, isDown) {
    if (event.key === 'Shift') this.shift = isDown;
    if (!MOVES[event.key] || !this.enabled) return false;
    if (isDown) this.keys.add(event.key);
    else this.keys.delete(event.key);
    return true;
  }
  beat() {
    if (!document.hidden) this.gap.take(performance.now());
    if (!this.enabled) return;
    const stick = this.readPad();
    if (this.engaged) {
      if (stick) this.go(this.view.drag(...stick.map((part) => (part * PAD_SPEED * REPORT_MS) / 1000)));
      for (const key of this.keys) this.go(this.view.drag(...MOVES[key].map((part) => (part * KEY_SPEED * REPORT_MS) / 1000)));
    }
    if (this.engaged || this.wasEngaged) this.tell();
  }
  // Reads a gamepad. Its first button or a trigger engages, the left stick moves in the plane of
  // the view, the right one along the third axis.
  readPad() {
    const pad = document.hasFocus() ? navigator.getGamepads().find((one) => one?.connected) : null;
    this.padHeld = Boolean(pad && [0, 6, 7].some((button) => pad.buttons[button]?.pressed));
    return pad && [pad.axes[0], pad.axes[1], -(pad.axes[3] || 0)].map((part) => (Math.abs(part) > PAD_SLACK ? part : 0));
  }
  tell() {
    const at = (this.sentAt = performance.now());
    this.link.send({ do: 'pointer', at, p_M: this.p, engaged: this.engaged, gap: this.gap.longest });
    if (this.engaged) this.sent = at;
    this.wasEngaged = this.engaged;
    this.clutch.setAttribute('aria-pressed', String(this.engaged));
    this.host.classList.toggle('held', this.engaged);
  }
  // Disengages because another page controls the tool, so that this page does not take over later.
  yieldControl() {
    this.release();
    this.heldElsewhereSince = -Infinity;
    this.isLedElsewhere = true;
  }
  // Disengages if the master has disengaged because this page was silent. Returns the reason, and
  // again while the measured silence grows, because the first status may be an old one.
  releaseIfHeld(status) {
    if (status.pointer_holds) this.heldBack = true;
    else if (this.heldBack && this.engaged && status.pointer_used > this.heldSince) {
      this.heldBack = false;
      this.release();
      this.silence = 0;
    }
    if (!this.engaged) this.heldBack = false;
    else this.silence = null;
    if (this.silence === null || status.pointer_silence <= this.silence) return null;
    this.silence = status.pointer_silence;
    return `The page was silent for ${Math.round(1e3 * this.silence)} ms, so the operator was disengaged: engage again.`;
  }
  // Measures the time from a report of the page to the status of the tick that used it.
  take(status) {
    if (!status.pointer_holds || this.engaged) this.heldElsewhereSince = null;
    else this.heldElsewhereSince ??= performance.now();
    this.isLedElsewhere = this.heldElsewhereSince !== null && performance.now() - this.heldElsewhereSince > ELSEWHERE_MS;
    if (!this.engaged || status.state === 'FOLLOWING') this.idleSince = null;
    else this.idleSince ??= performance.now();
    // The pointer was engaged before a fault of the slave or the link, so the master waits for a
    // disengagement first.
    this.isIdle = this.idleSince !== null && performance.now() - this.idleSince > ELSEWHERE_MS;
    this.clutch.classList.toggle('idle', this.isIdle);
    if (status.pointer_used && this.engaged && this.sent && status.pointer_used > (this.usedBefore || 0)) {
      const delay = performance.now() - status.pointer_used;
      this.delay = this.delay === null ? delay : 0.9 * this.delay + 0.1 * delay;
    }
    this.usedBefore = status.pointer_used;
  }
}
