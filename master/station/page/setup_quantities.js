// Parses numbers with units, as a person types them into a field: "8.8", "8,8", "8.8 mm", "0.88
// cm".

// Units by quantity, relative to the field's own unit.
const KINDS = {
  length: { usual: 'mm', units: { mm: 1, cm: 10, m: 1e3, um: 1e-3, 'µm': 1e-3, in: 25.4 }, accepted: 'mm, cm or m' },
  stress: { usual: 'kPa', units: { kPa: 1, Pa: 1e-3, MPa: 1e3, GPa: 1e6 }, accepted: 'Pa, kPa or MPa' },
  percent: { usual: '%', units: { '%': 1 }, accepted: '%' },
  plain: { usual: '', units: {}, accepted: 'a number without a unit' },
};
const FORM = /^([+-]?)(\d*)(?:([.,])(\d*))?(e[+-]?\d{1,2})?\s*([a-zµ%]*)$/i;

const unitOf = (units, typed) => Object.keys(units).find((unit) => unit === typed) ??
  Object.keys(units).find((unit) => unit.toLowerCase() === typed.toLowerCase() && typed !== 'mpa');

// Parses `text`: {value: in the field's unit, unit: as typed, step: of its last digit}; or {why}:
// why it is not accepted or is ambiguous.
export function quantity(text, kind) {
  const typed = String(text ?? '').trim(), { units, usual, accepted } = KINDS[kind];
  const wanted = `expected a number such as 8.8${usual && `, in ${usual}`}`;
  if (!typed) return { why: wanted };
  if (/\d[.,' \u00a0]\d{3}[.,]\d|\d['\u00a0 ]\d|[.,].*[.,]/.test(typed))
    return { why: `"${typed}": write it without separators of thousands` };
  const match = typed.match(FORM);
  if (!match || !(match[2] || match[4])) return { why: `"${typed}": ${wanted}` };
  const [, sign, whole, mark, part = '', power = '', unit] = match;
  if (mark === ',' && /^[1-9]\d{0,2}$/.test(whole) && /^\d{3}$/.test(part) && !power) {
    return { why: `"${typed}" could be ${whole}.${part} or ${whole}${part}: write one of them` };
  }
  const known = unit ? unitOf(units, unit) : usual;
  if (known === undefined) return { why: `"${unit}" is no unit of this field: expected ${accepted}` };
  const factor = units[known] ?? 1;
  return {
    value: Number(`${sign}${whole || 0}.${part || 0}${power}`) * factor,
    unit,
    step: factor * 10 ** (Number(power.slice(1)) - part.length),
  };
}
export const valueOf = (text, kind) => quantity(text, kind).value ?? NaN;

// Returns the error of a field that must be above 0; empty: none.
export function positive(text, name, kind) {
  const { value, why } = quantity(text, kind);
  if (why && String(text).trim()) return `${name}: ${why}.`;
  return value > 0 && Number.isFinite(value) ? '' : `${name}: expected a number above 0, in ${KINDS[kind].usual}.`;
}
// Returns the error of a field that must be within limits; empty: none.
export function within(text, name, kind, isWithin, limits) {
  const { value, why } = quantity(text, kind);
  if (why && String(text).trim()) return `${name}: ${why}.`;
  return isWithin(value) ? '' : `${name}: expected ${limits}.`;
}

// Returns one standard deviation of a typed number: its last digit may be wrong by a half.
export const typedSigma = (text, kind) => (quantity(text, kind).step ?? 0) / Math.sqrt(12);
