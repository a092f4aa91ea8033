// Limits how often something is drawn. If frames are late, as without a graphics card, it is drawn
// less often, so that messages of the master are processed in time.

const LATE_MS = 30;

export class Pace {
  // Period between two drawings: `minPeriod` on a fast machine, up to `maxPeriod` on a slow one
  // [ms].
  constructor(minPeriod, maxPeriod) {
    Object.assign(this, { minPeriod, maxPeriod, period: minPeriod, at: 0 });
  }
  // Adapts the period after two frames of the browser that were `gap` [ms] apart.
  adapt(gap) {
    this.period = Math.min(this.maxPeriod, Math.max(this.minPeriod, this.period * (gap > LATE_MS ? 1.12 : 0.97)));
  }
  isDue(now) {
    if (now - this.at < this.period) return false;
    this.at = now;
    return true;
  }
}
