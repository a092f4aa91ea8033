// Plane geometry of the set-up. Points are [u, v] in the image [px]: (0, 0) is the centre of the upper left pixel, v points down.

export const distance = ([a, b], [c, d]) => Math.hypot(c - a, d - b);
const cross = ([ax, ay], [bx, by]) => ax * by - ay * bx;
const minus = ([ax, ay], [bx, by]) => [ax - bx, ay - by];
const along = ([ax, ay], [bx, by], part) => [ax + part * (bx - ax), ay + part * (by - ay)];

// Returns the sides of a closed polygon, as pairs of neighbouring points.
export const sidesOf = (points) => points.map((point, i) => [point, points[(i + 1) % points.length]]);

// Returns the signed area: positive if the points run clockwise in the image, where v points down.
export const areaOf = (points) => sidesOf(points).reduce((sum, [a, b]) => sum + cross(a, b), 0) / 2;

// Returns the polygon counter-clockwise as displayed.
export const counterClockwise = (points) => (areaOf(points) > 0 ? [...points].reverse() : points);

export function centroidOf(points) {
  let [u, v, sum] = [0, 0, 0];
  for (const [a, b] of sidesOf(points)) {
    const part = cross(minus(a, points[0]), minus(b, points[0]));
    u += (part * (a[0] + b[0] + points[0][0])) / 3;
    v += (part * (a[1] + b[1] + points[0][1])) / 3;
    sum += part;
  }
  return [u / sum, v / sum];
}

const meet = ([a, b], [c, d]) => {
  const side = (p, q, r) => Math.sign(cross(minus(q, p), minus(r, p)));
  return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
};
export function crossesItself(points) {
  const sides = sidesOf(points);
  return sides.some((one, i) => sides.some((other, j) => j > i + 1 && !(i === 0 && j === sides.length - 1) && meet(one, other)));
}

export const contains = (points, [u, v]) =>
  sidesOf(points).filter(([a, b]) => a[1] > v !== b[1] > v && u < a[0] + ((v - a[1]) / (b[1] - a[1])) * (b[0] - a[0])).length % 2 === 1;

const CORNER = 0.7;  // larger turns are corners of the object [rad]
// Corrects a polygon whose sides cross a curved edge, half of each inside and half outside: moves
// its corners onto the edge and adds a point on the edge in the middle of each side. Between turns
// of t the arc is l t / 8 above a chord of length l: the corners are two thirds of that outside,
// the middles one third inside.
export function bent(polygon) {
  const count = polygon.length, at = (i) => polygon[(i + count) % count], way = (i) => minus(at(i + 1), at(i));
  const turns = polygon.map((_, i) => {
    const [a, b] = [way(i - 1), way(i)], turn = Math.atan2(cross(a, b), a[0] * b[0] + a[1] * b[1]);
    return Math.abs(turn) < CORNER ? turn : 0;
  });
  return polygon.flatMap((corner, i) => {
    const [before, after] = [way(i - 1), way(i)].map(([x, y]) => [x, y, Math.hypot(x, y)]);
    const high = ((before[2] + after[2]) / 2) * (turns[i] / 8), across = [before[0] / before[2] + after[0] / after[2], before[1] / before[2] + after[1] / after[2]];
    const long = Math.hypot(...across) || 1, inward = [-across[1] / long, across[0] / long];
    const middle = along(corner, at(i + 1), 0.5), risen = (after[2] * (turns[i] + turns[(i + 1) % count])) / 16 / 3;
    return [
      [corner[0] + (2 / 3) * high * inward[0], corner[1] + (2 / 3) * high * inward[1]],
      [middle[0] + (risen * after[1]) / after[2], middle[1] - (risen * after[0]) / after[2]],
    ];
  });
}

// Returns points of the closed polygon about every `spacing` px, including its corners.
export const denser = (points, spacing) => sidesOf(points).flatMap(([a, b]) => {
  const parts = Math.max(1, Math.round(distance(a, b) / spacing));
  return Array.from({ length: parts }, (_, i) => along(a, b, i / parts));
});

// Returns the point of a polyline nearest to `p` as {distance, at: [u, v], i: number of the
// segment's first point, part: share along it}.
export function nearestOn(points, p, isClosed = true) {
  const sides = isClosed ? sidesOf(points) : sidesOf(points).slice(0, -1);
  return sides.reduce((best, [a, b], i) => {
    const way = minus(b, a), length = way[0] ** 2 + way[1] ** 2;
    const part = length > 0 ? Math.min(1, Math.max(0, ((p[0] - a[0]) * way[0] + (p[1] - a[1]) * way[1]) / length)) : 0;
    const at = along(a, b, part), far = distance(at, p);
    return far < best.distance ? { distance: far, at, i, part } : best;
  }, { distance: Infinity });
}

// Returns where the ray from `p` along `way` crosses the closed polygon: [{at, i: number of the
// side's first point}], the nearest first.
export function crossingsWith(points, p, way) {
  return sidesOf(points).flatMap(([a, b], i) => {
    const side = minus(b, a), slope = cross(way, side), off = minus(a, p);
    const far = cross(off, side) / slope, part = cross(off, way) / slope;
    return slope !== 0 && far > 0 && part >= 0 && part < 1 ? [{ at: [p[0] + far * way[0], p[1] + far * way[1]], i, far }] : [];
  }).sort((a, b) => a.far - b.far);
}

// Fits a circle to the points by least squares of their squared distances: {centre, radius}; null:
// they are on a line.
export function fitCircle(points) {
  const n = points.length, mean = [0, 1].map((k) => points.reduce((sum, p) => sum + p[k], 0) / n);
  let [suu, suv, svv, suz, svz] = [0, 0, 0, 0, 0];
  for (const p of points) {
    const [u, v] = minus(p, mean), z = u * u + v * v;
    suu += u * u, suv += u * v, svv += v * v, suz += u * z, svz += v * z;
  }
  const determinant = suu * svv - suv * suv;
  if (!(determinant > 1e-9 * (suu + svv) ** 2)) return null;
  const a = (suz * svv - svz * suv) / determinant / 2, b = (suu * svz - suv * suz) / determinant / 2;
  return { centre: [mean[0] + a, mean[1] + b], radius: Math.sqrt(a * a + b * b + (suu + svv) / n) };
}

// Fits a line to points: {at: their mean, way: unit vector, off: rms of the residuals}.
function fitLine(points) {
  const n = points.length, at = [0, 1].map((k) => points.reduce((sum, p) => sum + p[k], 0) / n);
  let [suu, suv, svv] = [0, 0, 0];
  for (const p of points) {
    const [u, v] = minus(p, at);
    suu += u * u, suv += u * v, svv += v * v;
  }
  const angle = Math.atan2(2 * suv, suu - svv) / 2;
  return { at, way: [Math.cos(angle), Math.sin(angle)] };
}

const FAR_PX = 8, FAR_SHARE = 0.06, CORNER_SHARE = 0.12;

// Moves clicked corners to the intersections of lines that are fitted to the outline's points near
// each side. A side with fewer than four points near it stays as clicked.
export function refineCorners(corners, outline) {
  let now = corners;
  for (let round = 0; round < 2; ++round) {
    const lines = sidesOf(now).map(([a, b]) => {
      const length = distance(a, b), far = round === 0 ? Math.max(FAR_PX, FAR_SHARE * length) : FAR_PX / 2;
      const near = outline.filter((p) => {
        const place = nearestOn([a, b], p, false);
        return place.distance < far && place.part > CORNER_SHARE && place.part < 1 - CORNER_SHARE;
      });
      return near.length >= 4 ? trimmedLine(near) : fitLine([a, b]);
    });
    now = now.map((corner, i) => meeting(lines[(i + lines.length - 1) % lines.length], lines[i]) || corner);
  }
  return now;
}

// Fits a line without the quarter of the points that is farthest from a first fit, such as points
// on the tool.
function trimmedLine(points) {
  const { at, way } = fitLine(points), off = (p) => Math.abs(cross(minus(p, at), way));
  const kept = [...points].sort((a, b) => off(a) - off(b)).slice(0, Math.max(4, Math.ceil(0.75 * points.length)));
  return fitLine(kept);
}

function meeting(one, other) {
  const slope = cross(one.way, other.way);
  if (Math.abs(slope) < 0.05) return null;
  const part = cross(minus(other.at, one.at), other.way) / slope;
  return [one.at[0] + part * one.way[0], one.at[1] + part * one.way[1]];
}

// Returns the corners of a rectangle in the displayed order lower left, lower right, upper right,
// upper left.
export function orderCorners(corners) {
  const round = counterClockwise(corners);
  const first = round.reduce((best, [u, v], i) => (u - v < round[best][0] - round[best][1] ? i : best), 0);
  return [...round.slice(first), ...round.slice(0, first)];
}

// Fits a rectangle of `width` and `height` [m] to its ordered corners at `pixel` [m/px]: {origin:
// its lower left corner, turn: counter-clockwise rotation [rad], misfit: rms distance of the
// corners [px]}.
export function fitRectangle(corners, width, height, pixel) {
  const [w, h] = [width / pixel, height / pixel], model = [[0, 0], [w, 0], [w, h], [0, h]];
  const mean = [0, 1].map((k) => corners.reduce((sum, p) => sum + p[k], 0) / 4);
  let [c, s] = [0, 0];
  corners.forEach(([u, v], i) => {
    const [x, y] = [model[i][0] - w / 2, model[i][1] - h / 2], [a, b] = [u - mean[0], mean[1] - v];
    c += x * a + y * b, s += x * b - y * a;
  });
  const turn = Math.atan2(s, c), [cos, sin] = [Math.cos(turn), Math.sin(turn)];
  const place = ([x, y]) => [mean[0] + cos * (x - w / 2) - sin * (y - h / 2), mean[1] - sin * (x - w / 2) - cos * (y - h / 2)];
  const misfit = Math.sqrt(corners.reduce((sum, p, i) => sum + distance(p, place(model[i])) ** 2, 0) / 4);
  return { origin: place([0, 0]), turn, misfit };
}

// Returns the polygon with few of its points that stays within `tolerance` [px] of it
// (Douglas-Peucker).
export function simplify(points, tolerance) {
  const keep = (line) => {
    if (line.length < 3) return line;
    let [worst, at] = [0, 0];
    for (let i = 1; i + 1 < line.length; ++i) {
      const off = nearestOn([line[0], line[line.length - 1]], line[i], false).distance;
      if (off > worst) [worst, at] = [off, i];
    }
    if (worst <= tolerance) return [line[0], line[line.length - 1]];
    return [...keep(line.slice(0, at + 1)).slice(0, -1), ...keep(line.slice(at))];
  };
  const half = Math.floor(points.length / 2);
  return [...keep(points.slice(0, half + 1)).slice(0, -1), ...keep([...points.slice(half), points[0]]).slice(0, -1)];
}
