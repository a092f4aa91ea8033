// Evaluates a frozen image: checks its brightness, and finds the tool's tip in a box. `grey` is
// {width, height, levels: one number per pixel, 0 to 255}.

import { contains, crossingsWith, distance } from './setup_geometry.js';

const DARK = 60, BRIGHT_SHARE = 0.35, MIN_SPREAD = 8;  // [levels], share of bright pixels, [levels]
const WIDTH_OFF = 0.35;  // relative tolerance of the tool's width in the search for its sides
// Larger changes across a side count like this one, because edges of the background may be stronger
// [levels].
const CLEAR_STEP = 25;
// Largest slope of a tool's sides against the rows of the image, and step of the search.
const MAX_SLOPE = 0.36, SLOPE_STEP = 0.03;
const LESS = 0.2;  // weight of the stronger side relative to the weaker one
const NEAR_PX = 2;  // largest distance of a side from the bar that was found in all rows together
const MIN_STEP = 12;  // smallest change across an edge of the tool [levels]
const SLAB_PX = 6;  // rows per slab in the search for the tool's sides
// Smallest change along the tool within two pixels by which its motion is tracked reliably
// [levels].
const MIN_MARK = 20;
// Rows at the end where a camera may see the end's face, which moves differently from the front.
const UNDERSIDE_PX = 8;
const BACKGROUND_PX = 3;  // smallest number of background pixels before the tip
const PAST_PX = 10;  // distance beyond the box in which the tip is searched
// Margins and length of the template, as in the slave.
const SIDE_PX = 6, BEYOND_PX = 4, LENGTH_PX = 44;

const SHADED = 0.7;  // level of the end's face relative to that of the front, for light from above
const EDGE_PX = 4;  // largest distance of the edge from an outline that the slave has detected
// Largest shift of the tip by what is seen beyond its front, a little less than what the slave's
// check of the tool's end accepts beside its tolerance.
const SHIFT_PX = 0.8;
const CONSISTENT = 3;  // standard deviations between two estimates of the camera's height
// Smallest distance of the far edge of an upper face from the near one, and its largest relative
// difference from where a level camera would see it.
const FAR_FROM_PX = 5, FAR_OFF = 0.5;
const FAR_EDGE_PX = 0.4;  // standard deviation of the distance of both edges
// The far edge is searched beside the tool, in strips.
const BESIDE_TOOL_PX = 8, FAR_SPAN_PX = 40, FAR_STRIP_PX = 5;
const BLUR_PX = 0.5;  // blur of an edge, within which an edge behind it cannot be separated
const BESIDE_PX = [3, 4, 5, 6];  // distances from the tool's side at which the background is read
const VAGUE_PX = 0.4;  // largest scatter of the end among the lines along a flat tool
const SHAPE_PX = 8;  // on narrower tips a round end cannot be recognised
// Relative to the tip's width: distance from the axis at which the end is compared, and recess of a
// half circle there.
const SIDEWAYS = 0.35, HALF_CIRCLE = 0.143;
// As in the slave's search for the tip.
const DEPTHS_PX = [4, 10, 20], SEARCH_PX = 12, SAME_PX = 2, EQUAL = 0.01, MIN_SCORE = 0.6;

export function greyOf({ width, height, data }) {
  const levels = new Float32Array(width * height);
  for (let i = 0; i < levels.length; ++i) levels[i] = 0.299 * data[4 * i] + 0.587 * data[4 * i + 1] + 0.114 * data[4 * i + 2];
  return { width, height, levels };
}

// Returns why the image cannot be used; empty: it can.
export function imageTrouble({ levels }) {
  const counts = new Array(256).fill(0);
  for (const level of levels) ++counts[Math.min(255, Math.round(level))];
  const quantile = (share) => {
    let sum = 0;
    return counts.findIndex((count) => (sum += count) >= share * levels.length);
  };
  const [low, high] = [quantile(0.02), quantile(0.98)];
  if (high < DARK)
    return `The image is too dark: the brightest parts have ${high} of 255 levels, expected at least ${DARK}. Add light, or ` +
      'open the aperture.';
  if ((counts[254] + counts[255]) / levels.length > BRIGHT_SHARE)
    return 'The image is too bright: more than a third of it is white. Use less light, or a shorter exposure.';
  if (high - low < MIN_SPREAD) return 'The image shows nothing: all of it has the same brightness. Is the lens covered, or out of focus?';
  return '';
}

// Returns the level at a position between pixels.
export function levelAt({ width, height, levels }, u, v) {
  const x = Math.min(width - 1.001, Math.max(0, u)), y = Math.min(height - 1.001, Math.max(0, v));
  const i = Math.floor(x), j = Math.floor(y), a = x - i, b = y - j, at = j * width + i;
  return (1 - b) * ((1 - a) * levels[at] + a * levels[at + 1]) + b * ((1 - a) * levels[at + width] + a * levels[at + width + 1]);
}

const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];

// Returns the direction from the box to the object: [1, 0], [-1, 0], [0, 1] (down) or [0, -1].
export function directionTo([[u0, v0], [u1, v1]], outline) {
  const outside = [(u0 + u1) / 2, (v0 + v1) / 2].map((mid, k) => {
    const low = Math.min(...outline.map((p) => p[k])), high = Math.max(...outline.map((p) => p[k]));
    return { far: Math.max(low - mid, mid - high), towards: low - mid > mid - high ? 1 : -1 };
  });
  return outside[0].far > outside[1].far ? [outside[0].towards, 0] : [0, outside[1].towards];
}

// Returns the changes along a profile.
const changesOf = (profile) => profile.map((_, i) => (i > 0 && i + 1 < profile.length ? (profile[i + 1] - profile[i - 1]) / 2 : 0));
// Returns the subpixel position of the extremum of `values` near `i`.
function peakAt(values, i) {
  const [a, b, c] = [values[i - 1] ?? 0, values[i], values[i + 1] ?? 0].map(Math.abs), bend = a - 2 * b + c;
  return i + (bend < 0 ? Math.min(0.5, Math.max(-0.5, (a - c) / (2 * bend))) : 0);
}

// Finds a bar of about `width` [px] in all rows of changes together: {slope, left, right} in the
// first row; null: there is none. Edges of the background may be as strong as the tool's sides, but
// do not continue through all rows.
function barIn(rows, width) {
  const across = rows[0].length;
  let best = null;
  const side = (s, slope) => {
    let sum = 0;
    for (let a = 0; a < rows.length; ++a) sum += Math.min(CLEAR_STEP, Math.abs(rows[a][Math.round(s + slope * a)] ?? 0));
    return sum / rows.length;
  };
  for (let slope = -MAX_SLOPE; slope <= MAX_SLOPE + 1e-9; slope += SLOPE_STEP) {
    const strengths = Array.from({ length: across }, (_, s) => side(s, slope)), tall = Math.hypot(1, slope);
    for (let left = 1; left + 1 < across; ++left) {
      for (let right = left + Math.max(2, Math.ceil(tall * width * (1 - WIDTH_OFF))); right + 1 < across; ++right) {
        if (right - left > tall * width * (1 + WIDTH_OFF)) break;
        const weaker = Math.min(strengths[left], strengths[right]);
        const score = weaker + LESS * Math.max(strengths[left], strengths[right]);
        if (weaker > MIN_STEP / 4 && score > (best?.score ?? 0)) best = { score, slope, left, right };
      }
    }
  }
  return best;
}
// Returns the subpixel position of the largest change of a profile near `s`; null: there is none.
function sideNear(changes, s) {
  let best = null;
  for (let i = Math.max(1, Math.round(s - NEAR_PX)); i <= Math.min(changes.length - 2, Math.round(s + NEAR_PX)); ++i)
    if (Math.abs(changes[i]) > Math.max(MIN_STEP / 4, best === null ? 0 : Math.abs(changes[best]))) best = i;
  return best === null ? null : peakAt(changes, best);
}

// Returns the axis of the tool in the box from its sides in slabs: {at: point on the axis where the
// tool enters the box, d: unit vector towards the tip, width}; null: there is no tool. `place(a,
// s)`: a point of the box, a px along and s px across.
function axisOf(grey, place, d, length, across, width) {
  const slabs = Math.max(2, Math.floor((0.6 * length) / SLAB_PX)), found = [];
  const changes = Array.from({ length: slabs }, (_, slab) => changesOf(Array.from({ length: across }, (__, s) =>
    median(Array.from({ length: SLAB_PX }, (___, i) => levelAt(grey, ...place(slab * SLAB_PX + i, s)))))));
  const bar = barIn(Array.from({ length: slabs * SLAB_PX }, (_, a) => changes[Math.floor(a / SLAB_PX)]), width);
  if (!bar) return null;
  changes.forEach((profile, slab) => {
    const a = (slab + 0.5) * SLAB_PX - 0.5, sides = [bar.left, bar.right].map((s) => sideNear(profile, s + bar.slope * a));
    if (sides.every((s) => s !== null)) found.push([a, (sides[0] + sides[1]) / 2, sides[1] - sides[0]]);
  });
  if (found.length < Math.max(2, slabs / 2)) return null;
  // The median slope of all pairs is not affected by a single wrong slab.
  const slopes = found.flatMap(([a, s], i) => found.slice(i + 1).map(([b, t]) => (t - s) / (b - a)));
  const slope = median(slopes), start = median(found.map(([a, s]) => s - slope * a)), tall = Math.hypot(1, slope);
  const [from, to] = [place(0, start), place(1, start + slope)];
  return { at: from, d: [0, 1].map((i) => (to[i] - from[i]) / tall), width: median(found.map(([, , wide]) => wide)) / tall };
}

// Finds the tip of a tool of about `width` [px] in the box [[u0, v0], [u1, v1]]: {tip: [u, v],
// direction: unit vector in the image, width: in the image [px], box: of the template [[u, v], [u,
// v]] in whole pixels, beyond: whether the template contains the region before the tip}, or {why}:
// the reason why there is no tip. `vague`: whether its end differs little from the background;
// `nearer`: distance from the object to which the tool must approach [px]; null: it is near enough;
// `sigma`: standard deviation of the distance between tip and object by the camera's height [px];
// `aside`: visible part of its side [px]. `view`: result of viewOf (setup_scene.js).
export function findTip(grey, box, outline, width, isRound, view) {
  const d = directionTo(box, outline), n = [Math.abs(d[1]), Math.abs(d[0])], k = d[0] ? 0 : 1;
  const low = [0, 1].map((i) => Math.round(Math.min(box[0][i], box[1][i]))),
    high = [0, 1].map((i) => Math.round(Math.max(box[0][i], box[1][i])));
  const [length, across] = [high[k] - low[k] + 1, high[1 - k] - low[1 - k] + 1];
  // The edge where the tool enters, and the left or upper side.
  const back = d[k] > 0 ? low[k] : high[k], side = low[1 - k];
  if (length < 3 * SLAB_PX || across < 8)
    return { why: 'The box is too small: drag it around the tip, with some of the tool and of the background.' };

  const axis = axisOf(grey, (a, s) => [0, 1].map((i) => (i === k ? back + a * d[k] : side + s * n[i])), d, length, across, width);
  if (!axis)
    return {
      why: `No tool is seen in the box: expected a bar about ${Math.round(width)} px wide that enters the box opposite to ` +
        "the object. Drag the box around the tip, correct the tool's width, or put a plain sheet behind the tool and freeze again.",
    };
  const place = (a, s) => [axis.at[0] + a * axis.d[0] - s * axis.d[1], axis.at[1] + a * axis.d[1] + s * axis.d[0]];
  const within = Math.max(1, Math.floor((isRound ? 0.15 : 0.35) * axis.width)),
    boxed = Math.floor(length * Math.hypot(1, axis.d[1 - k] / axis.d[k]));
  // Whether a row is free up to the object, whose edge is some pixels wide.
  const isFree = (a) =>
    !contains(outline, place(a + BEYOND_PX, 0)) && place(a, 0).every((value, i) => value >= 0 && value < [grey.width, grey.height][i]);
  let long = boxed;
  while (long > boxed - 2 * BEYOND_PX && !isFree(long - 1)) --long;
  while (long < boxed + PAST_PX && isFree(long)) ++long;
  const along = Array.from({ length: long }, (_, a) => {
    let sum = 0;
    for (let s = -within; s <= within; ++s) sum += levelAt(grey, ...place(a, s));
    return sum / (2 * within + 1);
  });
  const rough = beforeStrip(grey, place, along, endOf(along, long), axis.width / 2);
  if (rough === null)
    return { why: "The tool's end is not seen in the box: enlarge it by 10 px towards the object, but not onto the object." };
  const { end, vague } = isRound ? { end: rough, vague: false } : endAcross(grey, place, rough, within, axis.width / 2);
  // The rows along a round tool end on its arc, on average before its apex.
  const seen = isRound ? end + (within * (within + 1)) / (3 * axis.width) : end, [ahead] = crossingsWith(outline, place(seen, 0), axis.d),
    gap = ahead ? distance(place(seen, 0), ahead.at) : 0, middle = [(grey.width - 1) / 2, (grey.height - 1) / 2],
    level = ahead ? [0, 1].reduce((sum, i) => sum + (ahead.at[i] - middle[i]) * axis.d[i], 0) : 0,
    { shift: seenBeyond, sigma: spread } = shiftOf(view, faceOf(along, end), gap, level);
  const eye = ahead && view.upper ? highOf(grey, outline, place, axis, view.upper, level) : null;
  const shift = seenBeyond + (eye === null ? 0 : (level - eye) * view.upper.tip),
    sigma = Math.hypot(spread, eye === null ? view.tilt : (FAR_EDGE_PX / view.upper.far) * view.upper.tip);
  // A tool beside the middle of the image shows one of its sides, which lies towards the middle.
  const [u, v] = place(seen, 0), off = (middle[0] - u) * -axis.d[1] + (middle[1] - v) * axis.d[0];
  const aside = view.underside * Math.abs(off), extra = Math.min(Math.max(0, axis.width - width), aside);
  const tip = place(seen - shift, (-Math.sign(off) * extra) / 2);
  if (contains(outline, tip))
    return { why: 'The tip lies on the object: in the frozen image the tool must not touch it. Lift the tool and freeze again.' };
  const template = templateAt(grey, place, along, end, axis), entry = crossingsWith(outline, tip, axis.d)[0]?.at;
  const follow = entry
    ? followOf(grey, place, { end, front: template.front, width: axis.width, isMarked: !template.beyond }, levelIn(grey, entry, axis))
    : null;
  const { box: cut, beyond } = template;
  return {
    tip,
    direction: axis.d,
    width: axis.width - extra,
    aside,
    vague,
    sigma,
    nearer: seenBeyond > SHIFT_PX + 2 * spread ? SHIFT_PX / view.underside : null,
    roundness: roundnessOf(grey, place, end, along, axis.width),
    follow,
    box: cut,
    beyond,
  };
}

// Returns by how much the tip appears nearer to the pressed edge than it is, and the standard
// deviation [px], averaged over the camera's possible heights above the edge. A camera below the tip
// sees the face of the tool's end; `face` is the part of that face at which the end was found. A
// camera above the edge sees the upper face of the object, so that the edge is found too high. `gap`:
// distance between tip and edge; `level`: distance of the edge below the middle of the image, which is
// the height of a level camera [px]. The page asks for a height of half the gap.
export function shiftOf({ underside, raised, heightSigma, levelSigma }, face, gap, level) {
  const isLevel = Math.abs(level - gap / 2) < CONSISTENT * Math.hypot(heightSigma, levelSigma);
  const weight = isLevel ? heightSigma ** 2 / (heightSigma ** 2 + levelSigma ** 2) : 0, sigma = heightSigma * Math.sqrt(1 - weight);
  const height = gap / 2 + weight * (level - gap / 2);
  // Gauss-Hermite quadrature of three points over the height.
  const places = [[-Math.sqrt(3), 1 / 6], [0, 2 / 3], [Math.sqrt(3), 1 / 6]].map(([k, part]) => [height + k * sigma, part]);
  const values = places.map(([h, part]) => [face * underside * Math.max(0, gap - h) + raised * Math.max(0, h), part]);
  const shift = values.reduce((sum, [value, part]) => sum + part * value, 0);
  return { shift, sigma: Math.sqrt(values.reduce((sum, [value, part]) => sum + part * (value - shift) ** 2, 0)) };
}

// Returns the height of the camera above the pressed edge of a block [px], measured from the far edge
// of its upper face, for a camera in any direction; null: there is no far edge near the place where a
// level camera would see it. `level`: the height of a level camera.
function highOf(grey, outline, place, { d, width }, { far }, level) {
  if (!(level * far > FAR_FROM_PX)) return null;
  const found = [], long = Math.ceil(level * far * (1 + FAR_OFF)) + 4, first = Math.max(3, Math.floor(level * far * (1 - FAR_OFF)));
  for (const side of [-1, 1]) {
    for (let s = width / 2 + BESIDE_TOOL_PX; s < width / 2 + BESIDE_TOOL_PX + FAR_SPAN_PX; s += FAR_STRIP_PX) {
      const edges = Array.from({ length: FAR_STRIP_PX }, (_, i) => crossingsWith(outline, place(0, side * (s + i)), d)[0]?.at);
      if (edges.some((at) => !at)) continue;
      // Levels away from the pressed edge, and the strongest change near the expected far edge.
      const levels = Array.from({ length: long }, (_, a) =>
        edges.reduce((sum, [u, v]) => sum + levelAt(grey, u - a * d[0], v - a * d[1]), 0) / FAR_STRIP_PX);
      const changes = changesOf(levels), strength = changes.map((change, a) => (a >= first && a < long - 2 ? Math.abs(change) : 0));
      const best = strength.indexOf(Math.max(...strength));
      if (strength[best] > MIN_STEP / 4) found.push(peakAt(changes, best));
    }
  }
  if (found.length < 4) return null;
  const apart = median(found), off = 1.4826 * median(found.map((value) => Math.abs(value - apart)));
  return off < 2 * FAR_EDGE_PX ? apart / far : null;
}

// Returns the levels of the background on both sides of the tool.
const besideAt = (grey, place, a, half) =>
  [-1, 1].map((side) => BESIDE_PX.reduce((sum, off) => sum + levelAt(grey, ...place(a, side * (half + off))), 0) / BESIDE_PX.length);

// Returns the end, moved back over pixels along the tool that equal the background beside it, such as
// the background above the upper face of a block.
function beforeStrip(grey, place, along, end, half) {
  if (end === null) return null;
  let a = Math.floor(end) - 1;
  const isBehind = (i) => besideAt(grey, place, i, half).every((value) => Math.abs(value - along[i]) < MIN_STEP);
  if (!isBehind(a)) return end;
  while (a > 1 && isBehind(a)) --a;
  return a > 1 ? a + 0.5 : end;
}

// Returns the median of the end position of a flat tool over lines along it, each with its own
// levels, because the background may have several parts. An edge behind the end, such as that of a
// block's upper face, is also visible beside the tool. The levels beside the tool are subtracted, and
// the end is where half of the step from the tool to the background on the same side of that edge is
// left. `vague`: too many lines show no end, or another one.
function endAcross(grey, place, rough, within, half) {
  const ends = [], level = (a, s) => levelAt(grey, ...place(a, s)), mean = (from, to, s) => (level(from, s) + level(to, s)) / 2;
  const beside = (a) => besideAt(grey, place, a, half), [before, beyond] = [rough - 3, rough + 3.5].map(beside);
  const ahead = mean(rough + 3, rough + 4, 0), rise = beyond.map((value, i) => value - before[i]);
  const isAcross =
    rise[0] * rise[1] > 0 && rise.every((value, i) => Math.abs(value) > MIN_STEP && Math.abs(beyond[i] - ahead) < MIN_STEP);
  // Searches backwards for the position where `share`, which grows towards the tool, is a half.
  const halfWay = (share) => {
    for (let a = rough + 3; a > rough - 3; a -= 0.25) {
      const [here, earlier] = [a, a - 0.25].map((at) => share(at) - 0.5);
      if (here * earlier <= 0 && here !== earlier) return a - (0.25 * here) / (here - earlier);
    }
    return null;
  };
  const edge = isAcross ? halfWay((a) => beside(a).reduce((sum, value, i) => sum + (beyond[i] - value) / rise[i] / 2, 0)) : null;
  for (let s = -within; s <= within; ++s) {
    const tool = mean(rough - 4, rough - 3, s), ground = mean(rough + 3, rough + 4, s);
    const between = ([left, right]) => left + ((right - left) * (s + half)) / (2 * half);
    const endBefore = (behind) => {
      if (Math.abs(tool - behind) < MIN_STEP) return null;
      return halfWay((a) => (level(a, s) - (edge === null ? behind : between(beside(a)))) / (tool - behind));
    };
    const near = endBefore(edge === null ? ground : between(before)), far = edge === null ? null : endBefore(between(beyond));
    const found = far !== null && far > edge + BLUR_PX ? far : near;
    if (found !== null) ends.push(found);
  }
  if (2 * ends.length < 2 * within + 1) return { end: rough, vague: true };
  const end = median(ends), off = 1.4826 * median(ends.map((value) => Math.abs(value - end)));
  return { end, vague: off > VAGUE_PX || 3 * ends.length < 2 * (2 * within + 1) };
}

// Estimates the face of the end, which a camera below the tool sees: returns the share of its
// length by which the detected end is beyond that of the front. The detected end is where the level
// is halfway to the background. The face is in the shade and has SHADED times the level of the
// front.
function faceOf(along, end) {
  const background = median(along.slice(-BACKGROUND_PX)), front = median(along.slice(Math.max(0, Math.floor(end) - 6), Math.floor(end) - 1));
  return Math.min(1, Math.max(0, (SHADED * front - background) / (front - background)));
}

// Moves the points of a curved outline along its normal onto the edge in the image, if there is one
// within EDGE_PX. Each moves by the median of its neighbours, so that other edges have no effect.
export function ontoEdge(grey, outline) {
  const count = outline.length, at = (i) => outline[(i + count) % count];
  const normals = outline.map((_, i) => {
    const [x, y] = [0, 1].map((k) => at(i + 2)[k] - at(i - 2)[k]), long = Math.hypot(x, y) || 1;
    return [y / long, -x / long];
  });
  const shifts = outline.map(([u, v], i) => {
    const [x, y] = normals[i], levels = [];
    for (let s = -EDGE_PX - 1; s <= EDGE_PX + 1; s += 0.5)
      levels.push([-1, 0, 1].reduce((sum, t) => sum + levelAt(grey, u + s * x - t * y, v + s * y + t * x), 0) / 3);
    const changes = levels.map((_, k) => (levels[k + 2] ?? NaN) - (levels[k - 2] ?? NaN)), strength = changes.map((change) => Math.abs(change) || 0);
    const best = strength.indexOf(Math.max(...strength));
    return strength[best] > MIN_STEP && best > 2 && best < levels.length - 3 ? peakAt(strength, best) / 2 - EDGE_PX - 1 : 0;
  });
  return outline.map(([u, v], i) => {
    const shift = median([-2, -1, 0, 1, 2].map((k) => shifts[(i + k + count) % count]));
    return [u + shift * normals[i][0], v + shift * normals[i][1]];
  });
}

// Returns how round the end of a tool is: 0 flat, 1 a half circle; null: it is too small in the
// image.
function roundnessOf(grey, place, end, along, width) {
  if (width < SHAPE_PX) return null;
  const aside = Math.round(SIDEWAYS * width),
    background = median(along.slice(-BACKGROUND_PX)),
    level = (background + along[Math.max(0, Math.floor(end) - 3)]) / 2;
  const endAt = (s) => {
    for (let a = Math.ceil(end) + 2; a > end - width; a -= 0.25) {
      const [here, before] = [a, a - 0.25].map((at) => levelAt(grey, ...place(at, s)));
      if ((here - level) * (before - level) <= 0 && here !== before) return a;
    }
    return end - width;
  };
  const middle = (endAt(-1) + endAt(0) + endAt(1)) / 3;
  return (middle - (endAt(-aside) + endAt(aside)) / 2) / (HALF_CIRCLE * width);
}

// Returns the median level of the object behind the point where the tool enters it.
function levelIn(grey, entry, { d, width }) {
  const levels = [];
  for (let a = 4; a < 4 + Math.max(8, width); ++a) {
    for (let s = -width / 2; s <= width / 2; s += 2)
      levels.push(levelAt(grey, entry[0] + a * d[0] - s * d[1], entry[1] + a * d[1] + s * d[0]));
  }
  return median(levels);
}

// Predicts whether the tool's template is still found at the tool when the object, with level
// `object`, is behind and beside its end. It uses the correlation along the tool, as the slave
// does; with marks only the tool itself. Returns {lost, object, background, tool: levels}.
function followOf(grey, place, { end, front, width, isMarked }, object) {
  const half = Math.max(1, Math.floor(width / 2 + (isMarked ? -2 : SIDE_PX))),
    rear = Math.max(1 + SEARCH_PX, front - LENGTH_PX),
    rows = [],
    whole = width / 2;
  for (let a = rear; a <= front; ++a) rows.push(a);
  const columns = Array.from({ length: 2 * half + 1 }, (_, i) => i - half),
    template = rows.flatMap((a) => columns.map((s) => levelAt(grey, ...place(a, s))));
  const levels = {
    object,
    background: median(columns.map((s) => levelAt(grey, ...place(end + BACKGROUND_PX, s)))),
    tool: median(rows.filter((a) => a < end - 2).map((a) => levelAt(grey, ...place(a, 0)))),
  };
  const lost = DEPTHS_PX.some((depth) => {
    // The edges of the tool are blurred by one pixel.
    const pressed = (a, s) => {
      const inTool = Math.min(1, Math.max(0, whole - Math.abs(s) + 0.5)) * Math.min(1, Math.max(0, end - a + 0.5));
      return a > end - depth
        ? inTool * levelAt(grey, ...place(Math.min(a, end - 2), s)) + (1 - inTool) * object
        : levelAt(grey, ...place(a, s));
    };
    const scores = [];
    for (let k = -SEARCH_PX; k <= SEARCH_PX; ++k)
      scores.push(
        correlation(
          template,
          rows.flatMap((a) => columns.map((s) => pressed(a + k, s))),
        ),
      );
    const best = scores.indexOf(Math.max(...scores)),
      isPeak = (i) => scores[i] >= (scores[i - 1] ?? -1) && scores[i] >= (scores[i + 1] ?? -1);
    const hasEqual = scores.some((score, i) => Math.abs(i - best) > SAME_PX && isPeak(i) && score > scores[best] - EQUAL);
    return Math.abs(best - SEARCH_PX) > SAME_PX || scores[best] < MIN_SCORE || hasEqual;
  });
  return { lost, ...levels };
}

function correlation(a, b) {
  const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length, [m, n] = [mean(a), mean(b)];
  let [ab, aa, bb] = [0, 0, 0];
  a.forEach((value, i) => {
    ab += (value - m) * (b[i] - n), aa += (value - m) ** 2, bb += (b[i] - n) ** 2;
  });
  return aa > 0 && bb > 0 ? ab / Math.sqrt(aa * bb) : 0;
}

// Returns the end of the tool: from the front of the box backwards, the first position halfway from
// the background to the tool.
function endOf(along, length) {
  const background = median(along.slice(-BACKGROUND_PX));
  const tool = median(along.slice(0, Math.ceil(length / 2))),
    first = along.findLastIndex((value) => Math.abs(value - background) > Math.max(MIN_STEP / 2, Math.abs(tool - background) / 2));
  if (first < 2 || first > length - BACKGROUND_PX) return null;
  const near = median(along.slice(Math.max(0, first - 3), first)), level = (background + near) / 2;
  for (let a = first + 2; a > 0; --a) {
    if ((along[a] - level) * (along[a - 1] - level) <= 0 && along[a] !== along[a - 1])
      return a - 1 + (level - along[a - 1]) / (along[a] - along[a - 1]);
  }
  return null;
}

// Returns the template as the slave makes it: the tool with a little background on either side. It
// has no region beyond the tip, where the object will be, unless the tool has no marks by which its
// position along the axis is measured.
function templateAt(grey, place, along, end, { d, width }) {
  const before = along.slice(0, Math.max(0, Math.floor(end) - UNDERSIDE_PX));
  const noise = 1.4826 * median(before.slice(2).map((value, i) => Math.abs(value - 2 * before[i + 1] + before[i]))) / Math.sqrt(6);
  const marks = changesOf(before).slice(1, -1).reduce((sum, change) => sum + width * change * change, 0);
  const isMarked = before.length > 8 && marks > width * Math.max(MIN_MARK * MIN_MARK, 100 * noise * noise);
  // The upright box around a rotated piece is longer.
  const half = width / 2 + SIDE_PX, slant = 2 * half * Math.abs(d[0] * d[1]);
  const front = end + (isMarked ? -1 : BEYOND_PX) - slant, rear = front - LENGTH_PX + slant;
  const corners = [rear, front].flatMap((a) => [place(a, -half), place(a, half)]), size = [grey.width, grey.height];
  const low = [0, 1].map((i) => Math.max(0, Math.ceil(Math.min(...corners.map((p) => p[i])))));
  const high = [0, 1].map((i) => Math.min(size[i] - 1, Math.floor(Math.max(...corners.map((p) => p[i])))));
  return { box: [low, high], beyond: !isMarked, front };
}
