// How often something is drawn. Where frames come late, as without a graphics card, drawing becomes rarer, so that messages
// of the master are still processed in time.

const LATE_MS = 30;

export class Pace {
  // Between two drawings: `least` where the machine can, `most` where it cannot [ms].
  constructor(least, most) {
    Object.assign(this, { least, most, period: least, at: 0 });
  }
  // Two frames of the browser were `gap` [ms] apart.
  see(gap) {
    this.period = Math.min(this.most, Math.max(this.least, this.period * (gap > LATE_MS ? 1.12 : 0.97)));
  }
  isDue(now) {
    if (now - this.at < this.period) return false;
    this.at = now;
    return true;
  }
}
