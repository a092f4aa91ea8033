// How often something is drawn. Where frames come late, as without a graphics card, drawing becomes rarer, so that messages
// of the master are still processed in time.

const LATE_MS = 30;

export class Pace {
  // Between two drawings: `minPeriod` where the machine can, `maxPeriod` where it cannot [ms].
  constructor(minPeriod, maxPeriod) {
    Object.assign(this, { minPeriod, maxPeriod, period: minPeriod, at: 0 });
  }
  // Two frames of the browser were `gap` [ms] apart.
  adapt(gap) {
    this.period = Math.min(this.maxPeriod, Math.max(this.minPeriod, this.period * (gap > LATE_MS ? 1.12 : 0.97)));
  }
  isDue(now) {
    if (now - this.at < this.period) return false;
    this.at = now;
    return true;
  }
}
