// Advice for each check of a force with one camera (slave/CHECKS.md), for a person who holds the
// tool.
export const CHECK_HELP = {
  model_range: 'the model is not made for this press: an alarm below says why; without one it is too deep, press less deeply',
  tip: 'the tip is covered, turned or out of view: show it to the camera as in the frozen image',
  arm: 'the tip is not where the manipulator says',
  image: 'blur or light differ from the start: hold the camera still, keep hands out of the light, switch automatic exposure off',
  registration: 'the edge of the object is not where it was: clear the view, or freeze and set up again',
  camera_motion: 'the camera has moved: fix it, then freeze and set up again',
  scale: 'the image has another scale than the scene: check zoom, scale and width of the tip',
  indentation: 'the surface gives way differently than computed: hold the tool in the plane, keep it straight, check the width of the tip',
  frozen: 'the camera repeats the same image: check camera and cable',
};

const AGAIN = 'Your answers are kept: try again.';
const BUSY = `The slave is busy and has not answered in time. ${AGAIN}`;
// Texts for rejected calls by ErrorReason (proto/palpate/v1/errors.proto), or by the code of the
// connection.
const NO_ADMIN = 'This station may not set up the slave: start palpate-master with --setup-tls and the certificate of an admin.';
const NO_CERTIFICATE = "The station's certificate has expired: it needs a new one.";
const REASONS = {
  ROLE_NOT_ALLOWED: NO_ADMIN, PERMISSION_DENIED: NO_ADMIN,
  CERTIFICATE_INVALID: NO_CERTIFICATE, UNAUTHENTICATED: NO_CERTIFICATE,
  LEASE_HELD: 'Somebody operates the slave. Wait until they have disengaged, then try again.',
  NEW_SCENE: `The slave starts again with a new scene. ${AGAIN}`,
  CHANGE_UNDER_WAY: `The slave still works on another request. ${AGAIN}`,
  TOOL_IN_USE: 'The tool is in use, or an emergency stop is active. End that first.',
  NOT_IN_SETUP: 'The slave accepts no set-up: start it with palpate-slave serve --setup FOLDER.',
  STOPPING: 'The slave is stopping. Start it again.',
  CANCELLED: BUSY,
  DEADLINE_EXCEEDED: BUSY,
  UNAVAILABLE: `The slave does not answer now: it is busy, was ended, or the connection is cut. ${AGAIN}`,
  NO_CAMERA: "The slave's camera gives no image: check camera and cable.",
};

// Texts for rejected data, by the call and a pattern of the slave's message.
const CALLS = [
  [
    'outline',
    /no clear edge|collapsed|left its start|intersected itself/,
    'No clear edge is near your clicks: click nearer to the edge, or light the object from the side.',
  ],
  ['outline', /./, 'The slave finds no outline there: click around the object again, near its edge.'],
  [
    'board',
    /none of \d+ images shows a board/,
    'The board is not seen: expected all of it in the image, flat, without glare, and with these numbers of inner corners.',
  ],
  ['board', /./, 'The board is not found in this image: hold it flat in the plane of the object, and freeze again.'],
  ['image', /./, "The slave's camera gives no image: check camera and cable."],
  ['use', /no new image|no image received/, "The slave's camera gives no image: check camera and cable."],
  ['use', /saved|written|folder/, 'The slave cannot save the scene: check the folder of --setup.'],
];

// Returns the text for a failed call. `error`: the slave's text, `reason`: name of the ErrorReason,
// `code`: code of gRPC.
export function callWords(call, { error, reason, code }) {
  const known = REASONS[reason] || (reason ? null : REASONS[code]);
  if (known) return known;
  return CALLS.find(([name, form]) => name === call && form.test(error))?.[2] || `The slave cannot do this now. ${AGAIN}`;
}

const lengthIn = (text) => text.match(/[\d.]+ ?(?:mm|um|µm|m)\b/)?.[0];
// Texts for mistakes in a scene, by the key and a pattern of the slave's message.
const SCENE = [
  [
    'tool.width',
    /another width/,
    ({ value, expected }) =>
      `The tip looks ${lengthIn(expected) || 'another width'} wide in the image, but you gave ${value}. Hold the tool in the ` +
      'plane of the ruler: one that is farther from the camera looks narrower. Or correct the width in this step.',
  ],
  [
    'sense.tip.template',
    /goes on beyond/,
    () => "The tool goes on beyond the tip that was found: drag a box with the tool's end in it, and some background before the end.",
  ],
  [
    'sense.tip.anchor',
    /not the end of the tool/,
    () =>
      'The tool has moved since the image was frozen, or its end was found elsewhere: hold it as in the frozen image, or ' +
      'drag the box again.',
  ],
  [
    'sense.tip',
    /touches the object/,
    ({ message }) =>
      `The tool touches the object in the camera's image now, ${message.match(/[\d.e-]+ mm deep/)?.[0] || 'a little'}: lift ` +
      'the tool, and check again.',
  ],
  ['sense.tip', /./, () => "The tip of the tool is not found in the camera's image now: hold it as in the frozen image, and check again."],
  [
    'object.geometry',
    /(larger|smaller) than in the scene/,
    ({ message }) =>
      `In the camera's image the object is ${message.match(/[\d.]+ % (larger|smaller)/)?.[0] || 'of another size'} than you ` +
      'measured: measure it again, check the scale of step 2, or click nearer to its edge.',
  ],
  [
    'object.geometry',
    /does not fit|deviates/,
    () =>
      "The outline in the camera's image now is not the one that you drew: the object has moved, something covers its edge, " +
      "or its shape is another one. Freeze again, and click around it.",
  ],
  [
    'sense.contour',
    /./,
    () =>
      "The edge of the object is not found in the camera's image now: click nearer to it, light the object from the side, or " +
      "clear what lies beside it.",
  ],
  ['object.geometry', /./, () => 'The slave cannot compute an object of these sizes: check shape, sides and thickness.'],
  ['object.material', /./, () => "The slave does not accept this material: check modulus, Poisson's ratio and uncertainty."],
  [
    'object.fixed',
    /./,
    () => 'The slave does not accept these held edges: hold a longer part of the edge, and leave the one free that you press.',
  ],
  [
    'sense.camera',
    /image|camera/,
    () => "The slave's camera gives no image, or is another one than at the start: check camera and cable, and freeze again.",
  ],
  ['tool', /./, () => 'The slave does not accept this tool: check width, end, and how far it reaches through the thickness.'],
  ['model', /./, () => 'The slave cannot compute this object: check the sizes, and thin or thick.'],
  ['name', /./, () => 'Name of the scene: expected letters, digits, - and _.'],
];
// Texts for messages without a key.
const KEYLESS = [
  [/collapsed|intersected itself|left its start|no clear edge/, 'sense.contour'],
  [/the object in the first image|the outline in the first image/, 'object.geometry'],
  [/no (?:new )?image/, 'sense.camera'],
  [/tip|template/, 'sense.tip'],
];

// Returns the key of a mistake and its text for a person: {key, text, details}.
export function mistakeWords({ key = '', value = '', message = '', expected = '' }) {
  const owner = key && !/^sense\.contour/.test(key) ? key : KEYLESS.find(([form]) => form.test(message))?.[1] || key;
  const row = SCENE.find(([begin, form]) => (owner === begin || owner.startsWith(`${begin}.`)) && form.test(message));
  const details = [key && `${key}${value ? ` = ${value}` : ''}`, message, expected && `expected ${expected}`].filter(Boolean).join(': ');
  return {
    key: owner,
    text: row?.[2]({ value, message, expected }) || 'The slave cannot use these answers. The details say why.',
    details,
  };
}
