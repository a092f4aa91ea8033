// Young's modulus from presses onto a kitchen scale: the force of a linear model is proportional to it.
import { valueOf } from './setup_quantities.js';
import { figure } from './text.js';

const HOLD_MS = 500;  // duration of the states that make one held press
const MIN_READINGS = 5;  // readings for a good fit
const LINEAR = ['bem2d', 'extruded', 'plate', 'plate-large', 'fem', 'fem-green'];
const UNITS = { g: 9.80665e-3, N: 1 };  // [N]
// Largest ratio of result and first guess: grams in place of newtons give 102.
const MAX_FACTOR = 30;
const SCATTER = 0.05;  // relative to the largest reading
const MIN_SPAN = 2;  // largest over smallest press
// 97.5 % quantiles of Student's t for 1, 2, ... degrees of freedom; beyond these 2.
const STUDENT = [12.71, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];
const NORMAL = 1.96;

const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];
const sum = (values) => values.reduce((total, value) => total + value, 0);

// Collects the newest states during a held press. Times in ms.
export class HeldPress {
  constructor() {
    this.points = [];
  }
  // `point`: a result of PressCurve.add.
  add(point, now) {
    this.points = [...this.points.filter(({ at }) => now - at < HOLD_MS), { ...point, at: now }];
  }
  // Returns medians {force, sigma, depth}, or {why: what is missing}.
  take(now) {
    const held = this.points.filter(({ at, force }) => now - at < HOLD_MS && force > 0), valid = held.filter((point) => point.valid);
    if (held.length < 3) return { why: 'The tool does not press the object: press, hold still, then hold this press.' };
    if (valid.length < held.length / 2) return { why: 'The force is flagged: see the words beside the force, then hold this press again.' };
    const of = (key) => median(valid.map((point) => point[key]));
    return { force: of('force'), sigma: of('sigma'), depth: of('depth') };
  }
}

// Returns why a model of this kind cannot be fitted; empty: it can.
export const modelProblem = (kind) =>
  LINEAR.includes(kind)
    ? ''
    : `The model ${kind} is not linear: its force is not proportional to the modulus. Identify the material by the guide ` +
      '"Identify a material".';

// Returns a reading [N]; NaN: no number.
export const newtons = (text, unit) => valueOf(text, 'plain') * UNITS[unit];

// Returns the modulus [Pa] that fits readings {force: estimated [N], sigma: of it, without the
// modulus [N], modulus: of the estimate [Pa], reading [N]}: {modulus, half: of the 95 % interval,
// tolerance: standard deviation, relative, warnings}; null: too few. `resolution`: of the scale
// [N].
export function fitModulus(readings, resolution) {
  const count = readings.length, x = readings.map(({ force, modulus }) => force / modulus), y = readings.map(({ reading }) => reading);
  if (count < 2) return null;
  const xx = sum(x.map((value) => value * value)), modulus = sum(x.map((value, i) => value * y[i])) / xx;
  const scatter = Math.sqrt(sum(x.map((value, i) => (y[i] - modulus * value) ** 2)) / (count - 1)),
    noise = Math.max(scatter, resolution / Math.sqrt(12));
  const random = ((STUDENT[count - 2] ?? 2) * noise) / Math.sqrt(xx);
  // The errors of the estimated forces have a common cause, such as the tip's position, so more
  // readings do not reduce them.
  const common = (NORMAL * modulus * sum(x.map((value, i) => (value * value * readings[i].sigma) / readings[i].force))) / xx;
  const half = Math.hypot(random, common);
  return { modulus, half, tolerance: half / NORMAL / modulus, warnings: warningsOf({ readings, x, y, modulus, scatter, resolution }) };
}

function warningsOf({ readings, x, y, modulus, scatter, resolution }) {
  const most = Math.max(...y),
    ratios = x.map((value, i) => y[i] / value),
    usual = median(ratios),
    factor = modulus / readings[0].modulus,
    list = [];
  if (x.length < MIN_READINGS) list.push(`${x.length} readings: take at least ${MIN_READINGS}, at different depths.`);
  if (factor > MAX_FACTOR || factor < 1 / MAX_FACTOR)
    list.push(`The result is ${figure(factor)} times the first guess: is the unit of the readings right?`);
  const odd = ratios.findIndex((ratio) => ratio > 2 * usual || ratio < usual / 2);
  if (odd >= 0) list.push(`Reading ${odd + 1} does not fit the others: check number and unit, or remove it.`);
  if (Math.max(...x) < MIN_SPAN * Math.min(...x)) list.push('All presses are about equally deep: press also less deeply.');
  const { start, deviation } = lineOf(x, y);
  if (odd < 0 && x.length > 2 && Math.abs(start) > Math.max((STUDENT[x.length - 3] ?? 2) * deviation, 2 * resolution, 0.01 * most))
    list.push(`Without a press the scale would show ${figure(start)} N: set it to zero with the object on it.`);
  else if (odd < 0 && scatter > SCATTER * most)
    list.push(
      `The readings are ${figure((100 * scatter) / most)} % off a line through zero: hold still while you read, and press straight down.`,
    );
  return list;
}

// Fits a line to the points. Returns its value at 0 and the standard deviation of that.
function lineOf(x, y) {
  const count = x.length,
    mean = sum(x) / count,
    xx = sum(x.map((value) => (value - mean) ** 2)),
    slope = sum(x.map((value, i) => (value - mean) * y[i])) / xx,
    start = sum(y) / count - slope * mean;
  const scatter = Math.sqrt(sum(x.map((value, i) => (y[i] - start - slope * value) ** 2)) / Math.max(1, count - 2));
  return { start, deviation: scatter * Math.sqrt(1 / count + (mean * mean) / xx) };
}
