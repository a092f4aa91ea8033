// Checks the answers of the set-up and makes a scene from them. Answers are texts as typed.
import {
  areaOf,
  bent,
  centroidOf,
  counterClockwise,
  crossesItself,
  crossingsWith,
  denser,
  distance,
  fitCircle,
  fitRectangle,
  orderCorners,
  refineCorners,
  sidesOf,
  simplify,
} from './setup_geometry.js';
import { positive, typedSigma, valueOf, within } from './setup_quantities.js';

// Titles of the steps. Each step owns the keys of the scene listed below.
export const STEPS = {
  image: 'Image',
  scale: 'Scale',
  object: 'Object',
  held: 'Held edges',
  material: 'Material',
  tool: 'Tool',
  check: 'Check',
  press: 'Press',
};
const OWNERS = [
  ['sense.camera.pixel', 'scale'],
  ['sense.camera.pose', 'object'],
  ['sense.camera', 'image'],
  ['object.geometry', 'object'],
  ['object.pose', 'object'],
  ['object.fixed', 'held'],
  ['object.material', 'material'],
  ['tool', 'tool'],
  ['sense.tip', 'tool'],
  ['sense.contour', 'object'],
  ['model.plane', 'object'],
  ['manipulator', 'tool'],
];
export const stepOfKey = (key) => OWNERS.find(([start]) => key === start || key.startsWith(`${start}.`))?.[1] || 'check';

const MIN_PX = 20;  // smallest distance of the two clicks of the scale
const WIDEST_M = 20, NARROWEST_M = 2e-5;  // limits of the width that an image shows
const SIZE_OFF = 0.05;  // largest difference of a measured side from the scale, relative
const SIDE_SEEN = 0.1;  // largest visible part of the tool's side, relative to its width
const TOOL_OFF = 0.12;  // largest error of the tool's width, as in the slave's check `scale`
const MIN_CLEAR = 0.5;  // smallest share of an outline with a visible edge
const SKEW_OFF = 0.03;  // largest distance of corners from a rectangle, relative to its diagonal
const SPACING_PX = 3;  // distance of the points of an outline
// More elements for a round tool, which touches with a part of its width.
const CIRCLE_POINTS = 120, ELEMENTS = { flat: 180, round: 360 };
// Elements of the front edge of a block, as in deploy/scenes/gel-cube.yaml.
const FRONT_ELEMENTS = 120;
// Largest accepted force error of a plane model; it is part of the uncertainty [%].
const PLANE_OFF = 10;
export const GUESS_OFF = 50;  // uncertainty of a guessed modulus [%]
// Names of the rows of deploy/scenes/materials.md.
export const MATERIALS = ['dragon-skin-10', 'ecoflex-00-10', 'ecoflex-00-30', 'ecoflex-00-50'];
export const TEMPLATE = 'tip.png', OUTLINE = 'outline.csv';

const MIN_ARC = 0.05;  // of a held arc [rad]

// `held`: numbers of edges; of a disc or an outline arcs {from, to} [rad], counter-clockwise as
// displayed around the object's middle; an arc without `to` waits for its other end. `confirmed`:
// texts of the questions that were answered with "right".
export const emptyAnswers = () => ({
  name: 'my-object',
  confirmed: [],
  image: null,
  scale: { by: 'clicks', points: [], length: '', distance: '', columns: '9', rows: '6', square: '', board: null },
  object: {
    kind: 'rectangle',
    points: [],
    width: '',
    height: '',
    diameter: '',
    sides: '',
    thickness: '',
    plane: 'stress',
    found: null,
    clear: null,
  },
  press: { held: null, reading: '', unit: 'g', resolution: '1', readings: [] },
  held: [],
  material: { by: 'modulus', name: '', modulus: '', poisson: '0.49', tolerance: '5', identified: '' },
  tool: { box: [], width: '', shape: 'flat', by: '', depth: '', seen: null },
});

// Answers with a history per step, so that each step can be undone separately.
export class Answers {
  constructor() {
    this.now = emptyAnswers();
    this.past = {};
  }
  set(step, value) {
    (this.past[step] ||= []).push(this.now[step]);
    this.now = { ...this.now, [step]: value };
  }
  change(step, part) {
    this.set(step, { ...this.now[step], ...part });
  }
  canUndo(step) {
    return Boolean(this.past[step]?.length);
  }
  undo(step) {
    if (this.canUndo(step)) this.now = { ...this.now, [step]: this.past[step].pop() };
  }
}

export const mm = (text) => 1e-3 * valueOf(text, 'length');  // [m]
export const kPa = (text) => valueOf(text, 'stress');
const plain = (text) => valueOf(text, 'plain'), percent = (text) => valueOf(text, 'percent');
const sidesIn = (text) => String(text).split(String(text).includes(';') ? ';' : /\s+/).map((part) => part.trim()).filter(Boolean);
export const isRound = ({ kind }) => kind === 'disc' || kind === 'outline';
export const digits = (value, count = 6) => String(Number(value.toPrecision(count)));
const length = (metres) => `${digits(1e3 * metres)} mm`;

// Returns the scale [m/px] from the two clicks or the board; NaN: unknown.
const clickedPixel = ({ scale: { by, board, points, length: text } }) =>
  by === 'board' ? (board?.pixel ?? NaN) : points.length === 2 ? mm(text) / distance(...points) : NaN;
// Returns why a search for a board is impossible; empty: it is possible.
export const boardProblems = ({ scale: { columns, rows, square } }) =>
  [
    ...([columns, rows].every((count) => plain(count) >= 3 && Number.isInteger(plain(count)))
      ? []
      : ['Inner corners of the board: expected whole numbers of 3 or more, one less than its squares.']),
    positive(square, 'Edge of a square', 'length'),
  ].filter(Boolean);

// Returns the corners or clicks of the object, moved onto the edge that the slave has detected.
const cornersOf = ({ points, found }) => (found?.length ? refineCorners(points, found) : points);
const KINDS = { rectangle: 'corners', polygon: 'corners', outline: 'points on the edge', disc: 'points on the edge' };
const fewest = { rectangle: 4, polygon: 3, outline: 3, disc: 3 };
export const isComplete = ({ kind, points }) => (kind === 'rectangle' ? points.length === 4 : points.length >= fewest[kind]);

// Returns measured sides as [m, px], each with its name.
function measuredSides(object) {
  const { kind, points, found } = object;
  if (!isComplete(object)) return [];
  if (kind === 'disc') {
    const circle = fitCircle(found?.length ? found : points);
    return circle ? [['diameter', mm(object.diameter), 2 * circle.radius]] : [];
  }
  const corners = cornersOf(object);
  if (kind === 'rectangle') {
    const [a, b, c, d] = orderCorners(corners);
    return [
      ['width', mm(object.width), (distance(a, b) + distance(d, c)) / 2],
      ['height', mm(object.height), (distance(a, d) + distance(b, c)) / 2],
    ];
  }
  if (kind === 'polygon')
    return sidesIn(object.sides).map((side, i) => [
      `side ${i + 1}`,
      mm(side),
      corners[i] ? distance(corners[i], corners[(i + 1) % corners.length]) : NaN,
    ]);
  return [];
}

// Returns the scale [m/px]: from the sides of a measured object if its edge was detected, because
// they are longer than most scales; else from the two clicks.
export function pixelOf(answers) {
  const clicked = clickedPixel(answers), sides = measuredSides(answers.object).filter(([, metres, px]) => metres > 0 && px > 0);
  if (!answers.object.found?.length || !sides.length) return clicked;
  return sides.reduce((sum, [, metres]) => sum + metres, 0) / sides.reduce((sum, [, , px]) => sum + px, 0);
}

// Contributions to the relative standard deviation of pixelOf: a click along the line, a detected
// edge, a board's square, and an uncorrected lens, whose scale changes from the middle to the
// corners: a third of the 1 to 2 % of common webcams.
const CLICK_PX = 2, FOUND_PX = 0.5, BOARD = 0.002, LENS = 0.005;
// Returns the typed sides [m].
const typedSides = ({ kind, width, height, diameter, sides }) =>
  ({ rectangle: [width, height], disc: [diameter], polygon: sidesIn(sides) })[kind] || [];
export function pixelToleranceOf(answers) {
  const { scale, object } = answers, sides = measuredSides(object).filter(([, metres, px]) => metres > 0 && px > 0);
  const lens = scale.by === 'board' ? 0 : LENS;
  if (object.found?.length && sides.length) {
    const typed = 1e-3 * Math.hypot(...typedSides(object).map((side) => typedSigma(side, 'length')));
    const found = (FOUND_PX * Math.sqrt(2 * sides.length)) / sides.reduce((sum, [, , px]) => sum + px, 0);
    return Math.hypot(lens, found, typed / sides.reduce((sum, [, metres]) => sum + metres, 0));
  }
  return scale.by === 'board' ? BOARD : Math.hypot(lens, (CLICK_PX * Math.SQRT2) / distance(...scale.points));
}

// Returns where the slave searches for the edge: near the clicks; for a disc near the circle
// through them.
export function startOf(object) {
  const circle = object.kind === 'disc' ? fitCircle(object.points) : null;
  return circle ? circlePoints(circle) : object.points;
}
// Returns points of the edge that the slave has detected as a polygon.
export const foundOf = ({ kind }, polygon) => denser(kind === 'outline' ? bent(polygon) : polygon, SPACING_PX);
const circlePoints = ({ centre, radius }) => Array.from({ length: CIRCLE_POINTS }, (_, i) => {
  const angle = (2 * Math.PI * i) / CIRCLE_POINTS;
  return [centre[0] + radius * Math.cos(angle), centre[1] - radius * Math.sin(angle)];
});

// Returns the outline in the image, counter-clockwise as displayed; [] while there is none.
export function outlineOf({ object }) {
  if (!isComplete(object)) return [];
  if (object.kind === 'outline') return counterClockwise(object.found?.length ? object.found : object.points);
  if (object.kind !== 'disc') return object.kind === 'rectangle' ? orderCorners(cornersOf(object)) : counterClockwise(cornersOf(object));
  const circle = fitCircle(object.found?.length ? object.found : object.points);
  return circle ? circlePoints(circle) : [];
}

// Returns the edges that can be fixed one by one, as polylines in the image, counter-clockwise. A
// disc or an outline has none: its arcs are fixed.
export function edgesOf(answers) {
  const outline = outlineOf(answers);
  return outline.length && !isRound(answers.object) ? sidesOf(outline) : [];
}

// Returns frame O: its origin in the image and its rotation in S [rad].
function frameOf(answers, pixel) {
  const outline = outlineOf(answers), { kind } = answers.object;
  if (kind === 'rectangle') return fitRectangle(outline, mm(answers.object.width), mm(answers.object.height), pixel);
  return { origin: kind === 'disc' ? fitCircle(outline).centre : centroidOf(outline), turn: 0 };
}

const SIDES = ['bottom', 'right', 'top', 'left'];
const angleFrom = (origin, [u, v]) => Math.atan2(origin[1] - v, u - origin[0]);
const turnTo = (from, to) => ((to - from) % (2 * Math.PI) + 2 * Math.PI) % (2 * Math.PI);

// Returns the centre in the image around which angles of fixed arcs are measured.
export const middleOf = (answers) => frameOf(answers, 1).origin;
export const angleAt = (answers, point) => angleFrom(middleOf(answers), point);
// Returns arcs that have both ends, as [from, span].
const arcsOf = ({ held }) => held.filter(({ to }) => to !== undefined).map(({ from, to }) => [from, turnTo(from, to)]);
export const isInArc = ({ from, to }, angle) => to !== undefined && turnTo(from, angle) <= turnTo(from, to);
// Returns the shorter arc between two angles.
export const arcBetween = (a, b) => (turnTo(a, b) <= Math.PI ? { from: a, to: b } : { from: b, to: a });

// Returns the fixed part of the outline as polylines in the image.
export function heldLines(answers) {
  if (!isRound(answers.object)) return answers.held.map((i) => edgesOf(answers)[i]).filter(Boolean);
  const outline = outlineOf(answers), middle = outline.length ? middleOf(answers) : null, lines = [];
  for (const arc of answers.held) {
    let line = null;
    for (const side of sidesOf(outline)) {
      const [a, b] = side, isIn = isInArc(arc, angleFrom(middle, [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2]));
      if (isIn && line) line.push(b);
      else if (isIn) lines.push((line = [...side]));
      else line = null;
    }
  }
  return lines;
}

// Returns runs of adjacent fixed edges, each as [first, last].
export function runsOf(held, count) {
  const isHeld = (i) => held.includes((i + count) % count);
  if (held.length >= count) return [[0, count - 1]];
  const starts = [...Array(count).keys()].filter((i) => isHeld(i) && !isHeld(i - 1));
  return starts.map((first) => {
    let last = first;
    while (isHeld(last + 1)) ++last;
    return [first, last % count];
  });
}

function fixedOf(answers, frame) {
  if (answers.object.kind === 'rectangle') return answers.held.map((i) => `{side: ${SIDES[i]}}`);
  const edges = edgesOf(answers),
    arcs = isRound(answers.object)
      ? arcsOf(answers)
      : runsOf(answers.held, edges.length).map(([first, last]) => {
          const from = angleFrom(frame.origin, edges[first][0]);
          return [from, turnTo(from, angleFrom(frame.origin, edges[last].at(-1)))];
        });
  return arcs.map(([from, span]) => {
    const middle = Math.atan2(Math.sin(from + span / 2), Math.cos(from + span / 2));
    return `{arc: {centre: ${digits(middle, 9)} rad, half_angle: ${digits(span / 2, 9)} rad}}`;
  });
}

// Returns whether only the fixed edges lie in their directions from the middle of a polygon.
function areEdgesApart(answers) {
  const edges = edgesOf(answers), { origin } = frameOf(answers, 1);
  return runsOf(answers.held, edges.length).every(([first, last]) => {
    const from = angleFrom(origin, edges[first][0]), span = turnTo(from, angleFrom(origin, edges[last].at(-1)));
    const inRun = (i) => (last >= first ? i >= first && i <= last : i >= first || i <= last);
    return edges.every(([a, b], i) => inRun(i) === (turnTo(from, angleFrom(origin, [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2])) <= span));
  });
}

// Returns where the tool's axis enters and leaves the object: {at: in the image, isHeld: fixed
// there}; null: it misses the object, or is unknown.
export function pathOf(answers) {
  const { seen } = answers.tool, outline = outlineOf(answers);
  if (!seen?.tip || !outline.length) return null;
  const crossings = crossingsWith(outline, seen.tip, seen.direction);
  if (crossings.length < 2) return null;
  const isHeld = ({ at, i }) =>
    isRound(answers.object) ? answers.held.some((arc) => isInArc(arc, angleAt(answers, at))) : answers.held.includes(i);
  const [first, last] = [crossings[0], crossings.at(-1)];
  return { enters: { at: first.at, isHeld: isHeld(first) }, leaves: { at: last.at, isHeld: isHeld(last) } };
}

// Excess length of a tool that reaches through the whole thickness, a millimetre on either side.
const OVERHANG_M = 2e-3;
// Returns distances along the view: from the front of the object to the front of the tool, and from
// there to its back [m]. The tool is in the middle.
export function depthsOf({ object, tool }) {
  const thick = mm(object.thickness);
  return tool.by === 'part' ? { front: (thick - mm(tool.depth)) / 2, deep: mm(tool.depth) } : { front: 0, deep: thick + OVERHANG_M };
}
// Returns the edge of a pixel in the plane of the tool's front [m].
export const toolPixelOf = (answers) => pixelOf(answers) * (1 + depthsOf(answers).front / mm(answers.scale.distance));
// Returns the visible length of the face of the tool's end, relative to the distance of the tip from
// the pressed edge, for a camera at the height of that edge. A camera that looks down on a block sees
// only the tool's front.
export function undersideOf(answers) {
  const { front, deep } = depthsOf(answers);
  return answers.object.plane === 'block' && answers.tool.by === 'part' ? 0 : deep / (mm(answers.scale.distance) + front + deep);
}
// Standard deviation of the camera's height above the edge, as set by a person.
const HEIGHT_SIGMA_M = 3e-3;
// Standard deviation of the direction of the camera's axis from level [rad].
const LEVEL_SIGMA = 0.01;
// Part of the visible upper face by which the edge is found too high. A rectangle of known size is
// also placed by its lower edge, a disc by its whole rim.
const RAISED = { outline: 1, polygon: 1, rectangle: 0.75, disc: 0.5 };
// Returns the effects of the camera's pose on the distance between tip and object, for setup_tip.js.
// `underside`: shift of the tool's end, relative to the camera's height below the tip. `raised`: shift
// of the edge, relative to the camera's height above it. `upper`: shifts of the far edge and of the
// tool's front towards the middle of the image, relative to the camera's height above the upper face
// of a block. `tilt`, `heightSigma`, `levelSigma`: standard deviations by a camera that is not level,
// of its height and of level [px].
export function viewOf(answers) {
  const { object, tool, scale } = answers, away = mm(scale.distance), thick = mm(object.thickness), pixel = toolPixelOf(answers);
  const { front } = depthsOf(answers), isUpperSeen = object.plane === 'block' && tool.by === 'part';
  return {
    underside: undersideOf(answers),
    raised: isUpperSeen ? 0 : (RAISED[object.kind] * thick) / (away + thick),
    tilt: (front * LEVEL_SIGMA) / pixel,
    upper: isUpperSeen ? { far: thick / (away + thick), tip: front / (away + front) } : null,
    heightSigma: HEIGHT_SIGMA_M / pixel,
    levelSigma: (away * LEVEL_SIGMA) / pixel,
  };
}

// Problems of each step as text; empty: none. `trouble`: problems of the frozen image and of the
// tool's box, see setup_tip.js.
const CHECKS = {
  image: ({ image }) =>
    image
      ? [image.trouble].filter(Boolean)
      : ['Freeze an image first: the object untouched, the tool in view above it, and a ruler in their plane.'],
  scale(answers) {
    const { by, board, points, length: text } = answers.scale,
      found = [];
    const away = positive(answers.scale.distance, 'Distance from the lens to the front of the object', 'length');
    if (by === 'board')
      return board ? [away].filter(Boolean) : [boardProblems(answers), ['Press "Find the board".']].find((list) => list.length);
    if (points.length < 2) return ['Click two marks of the ruler that are far apart.'];
    const far = distance(...points),
      wrong = positive(text, 'Length between the two marks', 'length');
    if (far < MIN_PX)
      found.push(`The two marks are ${Math.round(far)} px apart: expected at least ${MIN_PX} px. Click marks that are farther apart.`);
    found.push(...[wrong, away].filter(Boolean));
    const wide = clickedPixel(answers) * answers.image.width;
    if (!found.length && !(wide > NARROWEST_M && wide < WIDEST_M))
      found.push(`With this length the image would show ${digits(1e3 * wide, 2)} mm from left to right. Give the length in mm.`);
    return found;
  },
  object(answers) {
    const { object } = answers,
      { kind, points } = object,
      found = [];
    const name = KINDS[kind];
    if (!isComplete(object))
      return [
        `Click ${kind === 'rectangle' ? 'the four' : `${fewest[kind]} or more`} ${name}, in order around the object: ` +
        `${points.length} so far.`,
      ];
    if (kind !== 'disc' && crossesItself(kind === 'rectangle' ? points : outlineOf(answers)))
      return ['The outline crosses itself: click the points in order around the object.'];
    const outline = outlineOf(answers);
    if (!outline.length || Math.abs(areaOf(outline)) < 400)
      return ['The outline encloses almost nothing: click points all around the object.'];
    if (kind === 'disc') found.push(positive(object.diameter, 'Diameter', 'length'));
    if (kind === 'rectangle') found.push(positive(object.width, 'Width', 'length'), positive(object.height, 'Height', 'length'));
    const sides = sidesIn(object.sides).map(mm);
    if (kind === 'polygon' && sides.length && (sides.length !== points.length || !sides.every((side) => side > 0)))
      found.push(`Sides: expected ${points.length} lengths in mm with semicolons between, in the order of your clicks, or none.`);
    found.push(positive(object.thickness, 'Thickness', 'length'));
    const wrong = found.filter(Boolean);
    return wrong.length ? wrong : [...sizeProblems(answers), ...skewProblems(answers, outline), ...thicknessProblems(answers)];
  },
  held(answers) {
    const edges = edgesOf(answers),
      { held } = answers,
      arcs = isRound(answers.object) && arcsOf(answers),
      found = [];
    if (!held.length) {
      return [
        `Click ${arcs ? 'the two ends of each part of the edge that is held' : 'the edges where the object is held'}: glued, ` +
        'clamped, or lying on the table. Without one it would move away.',
      ];
    }
    if (arcs && held.length > arcs.length) return ['Click the other end of the held part.'];
    if (arcs ? arcs.reduce((sum, [, span]) => sum + span, 0) > 2 * Math.PI - MIN_ARC : held.length >= edges.length) {
      return ['All edges are held, so that none can be pressed: leave the edge free where the tool presses.'];
    }
    if (arcs?.some?.(([, span]) => span < MIN_ARC)) found.push('A held part is almost a point: click its two ends farther apart.');
    if (answers.object.kind === 'polygon' && !areEdgesApart(answers)) {
      found.push(
        'From the middle of the object, another edge is seen behind or before a held one. Hold that edge, too, or choose a ' +
        'simpler outline.',
      );
    }
    if (pathOf(answers)?.enters.isHeld)
      found.push('The tool would press an edge that you marked as held, and that cannot move: free this edge with a click.');
    return found;
  },
  material({ material: { by, name, modulus, poisson, tolerance } }) {
    const wrong = within(poisson, "Poisson's ratio", 'plain', (value) => value > -1 && value <= 0.5, 'more than -1 and at most 0.5');
    if (by === 'name') return name ? [wrong].filter(Boolean) : ['Choose a material, or give its modulus.'];
    const found = [positive(modulus, "Young's modulus", 'stress')];
    if (!found[0] && !(kPa(modulus) >= 1e-3 && kPa(modulus) <= 1e10)) found.push("Young's modulus: expected 0.001 to 1e10 kPa.");
    found.push(wrong);
    if (by === 'modulus') found.push(within(tolerance, 'Uncertainty', 'percent', (value) => value >= 0 && value <= 100, '0 to 100 %'));
    return found.filter(Boolean);
  },
  tool(answers) {
    const { box, width, by, depth, seen } = answers.tool,
      wrong = positive(width, 'Width of the tip', 'length');
    if (wrong) return [wrong];
    if (!by) return ['Choose how far the tool reaches through the thickness: the force depends on it.'];
    const short = by === 'part' ? positive(depth, 'Size of the tip in the direction of the thickness', 'length') : '';
    if (short) return [short];
    const thick = mm(answers.object.thickness);
    if (by === 'part' && mm(depth) > 1.02 * thick) {
      return [
        `The tip is ${digits(1e3 * mm(depth), 3)} mm deep, more than the thickness of the object, ${digits(1e3 * thick, 3)} ` +
        'mm: choose "through the whole thickness", or correct one of them.',
      ];
    }
    if (box.length < 2) return ['Drag a box around the tip of the tool, from one corner to the opposite one.'];
    if (!seen || seen.why) return [seen?.why || 'The tip was not searched yet.'];
    if (answers.object.plane === 'block' && answers.tool.shape === 'round')
      return [
        'Of a block, only a tool with a flat end is computed: take another tool. Of a round bar with a flat end, choose "flat", and ' +
        'enter 0.89 of its diameter for both sizes.',
      ];
    const wide = seen.width * toolPixelOf(answers),
      outline = outlineOf(answers),
      found = [];
    if (seen.nearer !== null)
      return [
        `The tool is too high, so that the camera sees the face of its end: hold it about ${digits(1e3 * seen.nearer * pixelOf(answers), 1)} ` +
        'mm above the object, and freeze again.',
      ];
    if (seen.aside > (SIDE_SEEN * mm(width)) / toolPixelOf(answers))
      return [
        'The camera sees a side of the tool: move the camera to the left or right until the tool is in the middle of the image, and ' +
        'freeze again.',
      ];
    if (Math.abs(wide / mm(width) - 1) > TOOL_OFF)
      found.push(
        `Width of the tip: ${digits(1e3 * mm(width), 3)} mm, but the image shows ${digits(1e3 * wide, 3)} mm: correct the ` +
        'width, or the scale.',
      );
    const largest = Math.max(...[0, 1].map((k) => Math.max(...outline.map((p) => p[k])) - Math.min(...outline.map((p) => p[k]))));
    if (seen.width > 0.8 * largest) found.push('The tip is nearly as wide as the object: expected at most 80 % of it.');
    if (!pathOf(answers))
      found.push(
        'The tool does not point at the object: hold it so that it would press the object when it moves along itself, and freeze again.',
      );
    return found;
  },
  check: () => [],
  press: () => [],
};
export function problemsAt(step, answers) {
  try {
    return CHECKS[step](answers);
  } catch {  // what it needs is answered at an earlier step
    return ['Answer the steps before this one first.'];
  }
}
// Returns the first step with a problem; null: none.
export const firstProblem = (answers) => Object.keys(STEPS).find((step) => problemsAt(step, answers).length) || null;

function sizeProblems(answers) {
  const clicked = clickedPixel(answers), found = answers.object.found, clear = answers.object.clear;
  const sides = measuredSides(answers.object)
    .filter(([, metres, px]) => Math.abs(metres / (px * clicked) - 1) > SIZE_OFF)
    .map(
      ([name, metres, px]) =>
        `The ${name} is ${digits(1e3 * metres, 3)} mm, but at the scale of step 2 the image shows ` +
        `${digits(1e3 * px * clicked, 3)} mm: correct the ${name}, the scale, or the ${KINDS[answers.object.kind]}.`,
    );
  if (found && clear !== null && clear < MIN_CLEAR)
    sides.push(
      `Only ${Math.round(100 * clear)} % of the outline lie on a clear edge: expected at least ` +
      `${Math.round(100 * MIN_CLEAR)} %. Click nearer to the edge, or light the object from the side.`,
    );
  return sides;
}

function skewProblems(answers, outline) {
  if (answers.object.kind !== 'rectangle') return [];
  const { misfit } = fitRectangle(outline, mm(answers.object.width), mm(answers.object.height), pixelOf(answers)),
    skew = misfit / distance(outline[0], outline[2]);
  return skew < SKEW_OFF
    ? []
    : [
        `The corners form no rectangle: they are ${Math.round(misfit)} px off. Click the corners again, or turn the camera ` +
        'so that it looks straight at the object.',
      ];
}

// Returns the larger and the smaller extent of the object in the image [m].
export function spansOf(answers) {
  const outline = outlineOf(answers), pixel = pixelOf(answers);
  const spans = [0, 1].map((k) => pixel * (Math.max(...outline.map((p) => p[k])) - Math.min(...outline.map((p) => p[k]))));
  return { larger: Math.max(...spans), smaller: Math.min(...spans) };
}

function thicknessProblems(answers) {
  const { object } = answers, { larger, smaller } = spansOf(answers), thick = mm(object.thickness), words = `${digits(1e3 * thick, 3)} mm`;
  if (!(larger > 0)) return [];
  if (object.plane === 'strain' && thick < smaller) {
    return [
      `You chose "thick", but the thickness of ${words} is less than the ${digits(1e3 * smaller, 3)} mm that the image ` +
      'shows: choose "thin" or "neither", or correct the thickness.',
    ];
  }
  if (object.plane === 'stress' && thick >= 0.9 * larger)
    return [
      `You chose "thin", but the thickness towards the camera is ${words}, as much as the width: choose "neither", or correct ` +
      'the thickness.',
    ];
  return thick < 100 * larger ? [] : [`The thickness is ${words}, more than a hundred times the width: correct one of them.`];
}

// Modulus, density and tolerance by name are the slave's; Poisson's ratio is that of the field. The force of a plane body is
// proportional to its thickness, and grows with about 0.3 of the width of a tool (a flat punch on a half plane): what the last digits
// of these two leave open is added to the tolerance, unless a scale has measured the product.
const WIDTH_SHARE = 0.3;
function materialText({ object, tool, material: { by, name, modulus, poisson, tolerance, identified } }) {
  if (by === 'name') return `{name: ${name}, poisson_ratio: ${plain(poisson)}}`;
  const relative = (text) => (100 * typedSigma(text, 'length')) / valueOf(text, 'length');
  const sizes = identified === modulus ? [] : [relative(object.thickness), WIDTH_SHARE * relative(tool.width)];
  return `{young_modulus: ${digits(kPa(modulus), 9)} kPa, poisson_ratio: ${plain(poisson)}, tolerance: ` +
    `${by === 'identify' ? GUESS_OFF : digits(Math.hypot(percent(tolerance), ...sizes), 3)} %}`;
}

function geometryText(answers, { origin }, pixel) {
  const { kind, width, height, diameter, thickness } = answers.object, outline = outlineOf(answers);
  const thick = `thickness: ${length(mm(thickness))}`, inO = ([u, v]) => [(u - origin[0]) * pixel, (origin[1] - v) * pixel];
  if (kind === 'rectangle') return [`rectangle: {width: ${length(mm(width))}, height: ${length(mm(height))}, ${thick}}`];
  if (kind === 'disc') return [`disc: {radius: ${length(mm(diameter) / 2)}, ${thick}}`];
  if (kind === 'polygon') return [`polygon: {points: [${outline.map((p) => `[${inO(p).map(length).join(', ')}]`).join(', ')}], ${thick}}`];
  return [`contour: ${OUTLINE}`, thick];
}

// Returns the scene of complete answers and its files: {scene, files: {name: Uint8Array}}.
// `cameraLines`: SceneDescription.setup_camera. `template`: PNG of answers.tool.seen.box.
export function sceneOf(answers, cameraLines, template) {
  const pixel = pixelOf(answers), frame = frameOf(answers, pixel), { image, object, tool } = answers, { tip, box, direction } = tool.seen;
  const centre = [((image.width - 1) / 2 - frame.origin[0]) * pixel, (frame.origin[1] - (image.height - 1) / 2) * pixel];
  const outline = simplify(outlineOf(answers), 1), size = [0, 1].map((k) => box[1][k] - box[0][k] + 1);
  const lines = [
    "# Made by the set-up of the operator's page.",
    `name: ${answers.name}`,
    'object:',
    '  geometry:',
    ...geometryText(answers, frame, pixel).map((line) => `    ${line}`),
    ...(Math.abs(frame.turn) > 1e-6 ? [`  pose: {rotation: [0, 0, ${digits(frame.turn, 8)} rad]}`] : []),
    `  material: ${materialText(answers)}`,
    `  fixed: [${fixedOf(answers, frame).join(', ')}]`,
    `tool: {shape: ${tool.shape}, width: ${length(mm(tool.width))}, depth: ` +
    `${tool.by === 'whole' ? 'whole' : length(mm(tool.depth))}, direction: [${digits(direction[0], 4)}, ` +
    `${digits(-direction[1] || 0, 4)}]}`,
    'sense:',
    '  camera:',
    ...cameraLines.map((line) => `    ${line}`),
    `    pixel: ${digits(1e3 * pixel, 8)} mm`,
    `    pixel_tolerance: ${digits(pixelToleranceOf(answers), 2)}`,
    `    distance: ${length(mm(answers.scale.distance))}`,
    `    pose: {translation: [${centre.map((value) => `${digits(1e3 * value, 8)} mm`).join(', ')}, 0]}`,
    `  tip: {track: template, template: ${TEMPLATE}, anchor: ` +
    `[${tip.map((value, k) => `${digits(value - box[0][k], 7)} px`).join(', ')}], ` +
    `anchor_tolerance: ${digits(tool.seen.sigma, 2)} px, roi: ` +
    `${Math.max(64, Math.max(...size) + 20)} px}`,
    '  contour: {track: snake, start: {polygon: ' +
    `[${outline.map((p) => `[${p.map((value) => `${digits(value, 5)} px`).join(', ')}]`).join(', ')}]}}`,
    object.plane === 'block'
      ? `model: {kind: extruded, elements: ${FRONT_ELEMENTS}, tolerance: ${PLANE_OFF} %}`
      : `model: {kind: bem2d, elements: ${ELEMENTS[tool.shape]}, plane: ${object.plane}, contact: bonded, tolerance: ${PLANE_OFF} %}`,
    'manipulator: none',
  ];
  const files = { [TEMPLATE]: template };
  if (object.kind === 'outline') {
    const points = outlineOf(answers).map(([u, v]) => [(u - frame.origin[0]) * pixel, (frame.origin[1] - v) * pixel]);
    files[OUTLINE] = new TextEncoder().encode(`x,y\n${points.map((p) => p.map((value) => value.toPrecision(8)).join(',')).join('\n')}\n`);
  }
  return { scene: `${lines.join('\n')}\n`, files };
}

const UNSEEN_PX = 0.5;  // three standard deviations of a well tracked tip
// Returns the contact stiffness along the surface normal [N/m].
function stiffnessAlong({ stiffness = [], normal }) {
  const n = [normal.x, normal.y, normal.z];
  return stiffness.length === 9 ? n.reduce((sum, a, i) => sum + n.reduce((part, b, j) => part + a * b * stiffness[3 * i + j], 0), 0) : 0;
}

// Collects the largest valid depth [m] and force [N], and the curve of the press: medians over
// depth.
export class PressCurve {
  constructor() {
    this.points = [];
  }
  // `state`: of state.proto, as JSON; `pixel` [m]. Returns its point {depth, force, sigma, valid,
  // isTouching, unseen}; null: it has no force. `unseen`: force at a depth equal to the tip's
  // uncertainty.
  add(state, pixel = 0) {
    const { force, local_model: model, p_S_tip: tip } = state;
    if (!force || !model?.reference || !tip || this.last === state.sequence) return null;
    this.last = state.sequence;
    const depth = ['x', 'y', 'z'].reduce((sum, axis) => sum + (model.reference[axis] - tip[axis]) * model.normal[axis], 0);
    const point = {
      depth: model.in_contact ? Math.max(0, depth) : 0,
      force: Math.hypot(force.x, force.y, force.z),
      sigma: state.sigma,
      valid: state.validity === 'VALIDITY_VALID',
      isTouching: Boolean(model.in_contact),
      unseen: UNSEEN_PX * pixel * stiffnessAlong(model),
    };
    if (model.in_contact) this.points.push(point);
    if (this.points.length > 3000) this.points.splice(0, 1000);
    return point;
  }
  get largestValid() {
    return this.points.reduce((most, { depth, valid }) => (valid && depth > most ? depth : most), 0);
  }
}
