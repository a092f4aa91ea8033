// The force over time of another recording, to be compared with this one.

// Share of the peak force at which the press of the other recording begins.
const CONTACT_SHARE = 0.02;

// Reads `text`, a file of "Share", or `states.csv` of palpate.export. Returns {times, forces,
// contact} [s, N], or null: no forces.
export function forcesIn(text) {
  const rows = text.match(/<script type="application\/json" id="clip">/) ? ofShared(text) : ofTable(text);
  const known = rows.filter(({ t, force }) => Number.isFinite(t) && Number.isFinite(force));
  if (!known.length) return null;
  const [times, forces] = [known.map(({ t }) => t), known.map(({ force }) => force)];
  const least = CONTACT_SHARE * forces.reduce((most, force) => Math.max(most, force), 0);
  return { times, forces, contact: times[Math.max(0, forces.findIndex((force) => force > least))] };
}

function ofShared(text) {
  try {
    const { states } = JSON.parse(text.match(/id="clip">([^]*?)<\/script>/)[1]);
    return states.map(({ t, force }) => ({ t, force: force ?? NaN }));
  } catch {
    return [];
  }
}

function ofTable(text) {
  const [head, ...lines] = text.trim().split(/\r?\n/).map((line) => line.split(','));
  const columns = ['t', 'force_x', 'force_y', 'force_z'].map((name) => head.indexOf(name));
  if (columns.includes(-1)) return [];
  const numberOf = (cell) => (cell ? Number(cell) : NaN);
  return lines.map((cells) => {
    const [t, ...force] = columns.map((column) => numberOf(cells[column]));
    return { t, force: Math.hypot(...force) };
  });
}

// Returns the force [N] `since` seconds after the contact; null: outside of the recording.
export function forceSince({ times, forces, contact }, since) {
  const t = contact + since;
  let [low, high] = [0, times.length - 1];
  if (t < times[low] || t > times[high]) return null;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  const span = times[high] - times[low];
  return span > 0 ? forces[low] + ((t - times[low]) / span) * (forces[high] - forces[low]) : forces[low];
}
