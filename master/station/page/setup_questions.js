// Plausibility questions: the page asks a person about unlikely answers before it shows a force.
import { distance, nearestOn } from './setup_geometry.js';
import { valueOf } from './setup_quantities.js';
import { depthsOf, digits, firstProblem, kPa, mm, pathOf, pixelOf, problemsAt, spansOf, STEPS } from './setup_scene.js';

const NARROW_M = 0.03, WIDE_M = 1.5;  // usual width of the view of a webcam
const MIN_ANGLE = 30, MAX_ANGLE = 100;  // usual horizontal field of view of a webcam [degrees]
// Visible depth of a tip behind the front of a block, relative to its smaller side.
const SEEN_DEPTH = 0.05;
const THIN = 0.04, NEITHER = 0.5, THICK = 3;  // thickness relative to the larger side
const SOFT_KPA = 0.5, STIFF_KPA = 5000;  // usual modulus of objects that are pressed by hand
const MIN_POISSON = 0.2, MIN_TOLERANCE = 0.5;  // [-], [%]
const KNIFE = 0.25, BAR = 4;  // extent of a tool through the thickness, relative to its width
// Distance from a click to the detected edge, relative to the outline's extent.
const PULLED = 0.04, PULLED_PX = 10;
const ROUND = 0.6, FLAT = 0.4;  // relative to the height of a half circle

// Familiar objects, each for larger sides below so many metres.
const SIZES = [
  [3e-3, 'a match head'],
  [7e-3, 'the width of a pencil'],
  [0.016, 'a fingernail'],
  [0.03, 'a coin'],
  [0.065, 'a matchbox'],
  [0.13, 'the palm of a hand'],
  [0.35, 'a sheet of paper'],
  [1, 'a pillow'],
];
const largeAs = (metres) => SIZES.find(([below]) => metres < below)?.[1] || 'a table';
const inMm = (metres) => `${digits(1e3 * metres, 3)} mm`;

// Questions: {text; wrong: field to correct, or an act of setup.js; texts of its two buttons}.
const ASKED = {
  image: () => [],
  scale(answers) {
    const wide = pixelOf({ ...answers, object: { ...answers.object, found: null } }) * answers.image.width;
    const angle = (360 / Math.PI) * Math.atan(wide / 2 / mm(answers.scale.distance)),
      found = [];
    if (!(angle >= MIN_ANGLE && angle <= MAX_ANGLE))
      found.push({
        wrong: 'scale.distance',
        text: `The lens would be ${inMm(mm(answers.scale.distance))} away from an image that is ${inMm(wide)} wide: it would see ` +
          `${Math.round(angle)} degrees. Is that right? Webcams see 50 to 80 degrees: check the distance and the length.`,
      });
    if (!(wide >= NARROW_M && wide <= WIDE_M))
      found.push({
        wrong: answers.scale.by === 'board' ? 'scale.square' : 'scale.length',
        text: `The whole image would be ${inMm(wide)} wide, about as ${wide < 1 ? 'large as' : 'wide as'} ${largeAs(wide)}. ` +
          `Is that right? A webcam seldom sees so ${wide < NARROW_M ? 'near' : 'far'}: check whether the length is in mm or cm.`,
      });
    return found;
  },
  object(answers) {
    const { object } = answers,
      { larger } = spansOf(answers),
      thick = mm(object.thickness),
      ratio = thick / larger,
      found = [],
      field = 'object.thickness';
    if (ratio < THIN)
      found.push({
        wrong: field,
        text: `The object would be ${inMm(larger)} large, but only ${inMm(thick)} thick towards the camera: a sheet on its ` +
          'edge. Is that right?',
      });
    if (object.plane === 'stress' && ratio > NEITHER)
      found.push({
        wrong: field,
        text: `The object would be ${inMm(thick)} thick towards the camera, and ${inMm(larger)} large: nearly a cube, not a ` +
          'slab. Is that right? Choose "neither" for a block.',
      });
    if (object.plane === 'strain' && ratio < THICK)
      found.push({
        wrong: 'object.plane',
        text: `You chose "thick": the object would be ${inMm(thick)} deep towards the camera, and ${inMm(larger)} large. ` +
          'Thick means several times as deep as wide. Is that right?',
      });
    if (larger < 0.01)
      found.push({
        wrong: 'object.kind',
        text: `The object would be ${inMm(larger)} large, about as large as ${largeAs(larger)}. Is that right?`,
      });
    const far = farthestClick(object);
    if (far)
      found.push({
        wrong: 'useClicks',
        words: ['The line is right', 'My clicks are right'],
        text: `The edge that was found lies ${Math.round(far)} px from one of your clicks. Look at the image: is the drawn ` +
          'line the edge of the object?',
      });
    return found;
  },
  held(answers) {
    const path = pathOf(answers);
    if (!path || path.leaves.isHeld) return [];
    return [
      {
        wrong: 'held',
        text: 'The tool presses towards an edge that is not held: nothing would lie against it on the other side. Is that right?',
        words: ['Right', 'Hold it, too'],
      },
    ];
  },
  material({ material: { by, modulus, poisson, tolerance } }) {
    const found = [], nu = valueOf(poisson, 'plain'), off = valueOf(tolerance, 'percent');
    if (by !== 'name' && !(kPa(modulus) >= SOFT_KPA && kPa(modulus) <= STIFF_KPA)) {
      found.push({
        wrong: 'material.modulus',
        text: `Young's modulus would be ${digits(kPa(modulus))} kPa. Is that right? Soft objects have ${SOFT_KPA} to ` +
          `${STIFF_KPA} kPa, silicone of Shore 00-30 about 100 kPa: check whether the number is in kPa, Pa or MPa.`,
      });
    }
    if (nu < MIN_POISSON)
      found.push({
        wrong: 'material.poisson',
        text: `Poisson's ratio would be ${nu}. Rubbers and gels have 0.49, foams about 0.3. Is that right?`,
      });
    if (by === 'modulus' && off < MIN_TOLERANCE)
      found.push({
        wrong: 'material.tolerance',
        text: `The modulus would be known within ${off} %. Is that right? Few laboratories reach 2 %.`,
      });
    return found;
  },
  tool(answers) {
    const { width, shape, by, depth, seen } = answers.tool,
      wide = mm(width),
      thick = mm(answers.object.thickness),
      deep = by === 'whole' ? thick : mm(depth),
      isBlock = answers.object.plane === 'block',
      { front } = depthsOf(answers),
      above = (SEEN_DEPTH * spansOf(answers).smaller * mm(answers.scale.distance)) / front,
      found = [];
    if (by === 'whole' && deep > BAR * wide)
      found.push({
        wrong: 'tool.by',
        text: `The tool would be a bar of ${inMm(wide)} x ${inMm(deep)} that reaches through the whole object. Is that ` +
          'right? A stick reaches through a part only.',
      });
    if (by === 'part' && (deep < KNIFE * wide || deep > BAR * wide))
      found.push({
        wrong: 'tool.depth',
        text: `The tip would be ${inMm(wide)} wide, and ${inMm(deep)} in the direction of the thickness. Is that right?`,
      });
    if (isBlock && by === 'part')
      found.push({
        wrong: 'image',
        words: ['It is', 'I move the camera'],
        text: `The tip goes ${inMm(front)} behind the front of the block. Is the camera at least ${inMm(above)} higher than the edge ` +
          'that you press, and does it look level, so that it still sees the tip in the block?',
      });
    else if (by === 'part' && deep < 0.9 * thick)
      found.push({
        wrong: 'image',
        words: ['It is', 'I move the camera'],
        text: `The tip of ${inMm(deep)} goes behind the front edge of the object, ${inMm(thick)} thick. Is the camera at the ` +
          'height of the edge that you press, so that it still sees the tip? From above or below, the front edge hides it.',
      });
    const { roundness } = seen;
    if (shape === 'round' ? roundness !== null && roundness < FLAT : roundness > ROUND)
      found.push({
        wrong: 'otherShape',
        words: [`It is ${shape}`, `It is ${shape === 'round' ? 'flat' : 'round'}`],
        text: `You chose a ${shape} end, but in the image it looks ${shape === 'round' ? 'flat' : 'round'}. Which is it?`,
      });
    if (seen.vague)
      found.push({
        wrong: 'image',
        words: ['Go on without', 'I freeze again'],
        text: 'The end of the tool hardly differs from what is behind it, so that the force would be uncertain. Put a plain sheet, much ' +
          'brighter or darker than the tool, behind it, and freeze again.',
      });
    if (seen.follow?.lost) found.push({ wrong: 'image', words: ['Go on without', 'I freeze again'], text: followWords(seen.follow) });
    return found;
  },
  check: () => [], press: () => [],
};

// Returns the largest distance of the outline from a click that it should pass [px]; 0: within the
// usual distance.
function farthestClick(object) {
  const { points, found } = object;
  if (!found?.length) return 0;
  const extent = Math.max(...points.map((point) => distance(point, points[0])));
  const far = Math.max(...points.map((point, i) => distance(point, nearestOn(found, point).at)));
  return far > Math.max(PULLED_PX, PULLED * extent) ? far : 0;
}

// Returns advice for a tip that cannot be tracked.
export function followWords({ object, background, tool }) {
  const other = object > background ? 'brighter' : 'darker',
    unlike = Math.abs(tool - object) < Math.abs(tool - background) ? `The tool is about as bright as the object. ` : '';
  return `The tip would probably be lost at the first touch: the object is much ${other} than what is behind the tool now. ` +
    `${unlike}Wind a strip of tape with dark and bright stripes around the tool, just above its end, or put a sheet that is ` +
    `as ${object > background ? 'bright' : 'dark'} as the object behind it. Then freeze again.`;
}

// Returns the questions of a step without problems that were not answered with "right".
export function questionsAt(step, answers) {
  if (problemsAt(step, answers).length) return [];
  try {
    return ASKED[step](answers).filter(({ text }) => !answers.confirmed.includes(text));
  } catch {  // an answer that it needs is missing at an earlier step
    return [];
  }
}
// Returns the first step with a problem or a question; null: none.
export const firstOpen = (answers) => firstProblem(answers) || Object.keys(STEPS).find((step) => questionsAt(step, answers).length) || null;

const SIDES = ['lower', 'right', 'upper', 'left'];
function heldWords(answers) {
  const { held, object } = answers;
  if (object.kind === 'rectangle') return `Held: the ${held.map((i) => SIDES[i]).join(' and the ')} edge.`;
  return `Held: ${held.length === 1 ? 'one part' : `${held.length} parts`} of the edge, drawn in red.`;
}
function sizeWords(answers) {
  const { object } = answers, { larger, smaller } = spansOf(answers), thick = inMm(mm(object.thickness));
  const sizes =
    {
      rectangle: () => `${inMm(mm(object.width))} wide and ${inMm(mm(object.height))} high`,
      disc: () => `a disc of ${inMm(mm(object.diameter))}`,
    }[object.kind]?.() || `${inMm(larger)} by ${inMm(smaller)}`;
  return `The object is ${sizes}, about as large as ${largeAs(larger)}, and ${thick} thick.`;
}
function toolWords({ tool, object }) {
  const depth =
    tool.by === 'whole' ? `through the whole thickness of ${inMm(mm(object.thickness))}` : `${inMm(mm(tool.depth))} into the thickness`;
  return `The tool has a ${tool.shape} end, ${inMm(mm(tool.width))} wide, and reaches ${depth}.`;
}

// Returns the sentences that a person confirms before a force is shown: [{step, text}]. `report`:
// the slave's check, with its line "in words".
export function sentencesOf(answers, report) {
  const [, stiffness, force] = report.match(/^ *in words +.*?about as stiff as (.*); (.*)$/m) || [];
  return [
    { step: 'object', text: sizeWords(answers) },
    ...(stiffness ? [{ step: 'material', text: `It is about as stiff as ${stiffness}.` }] : []),
    ...(force ? [{ step: 'material', text: `${force[0].toUpperCase()}${force.slice(1)}.` }] : []),
    { step: 'tool', text: toolWords(answers) },
    { step: 'held', text: heldWords(answers) },
  ];
}
