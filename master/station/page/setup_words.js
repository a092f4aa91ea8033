// For each check of a force with one camera (slave/CHECKS.md): what to do, for a person who holds the tool.
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

// Errors of the slave that a person can correct here, in the words of the page.
const ERRORS = [
  [/role '.*' may not call/, 'This station may not set up the slave: start palpate-master with --setup-tls and the certificate of an admin.'],
  [/none of \d+ images shows a board/, 'The board is not seen: expected all of it in the image, flat, without glare, and with these numbers of inner corners.'],
  [/found no clear edge/, 'No clear edge is near your clicks: click nearer to the edge, or light the object from the side.'],
  [/the tool goes on beyond the tip/, "The tool goes on beyond the tip that was found: drag a box with the tool's end in it, and some background before the end."],
];
export const inWords = (error) => ERRORS.find(([form]) => form.test(error))?.[1] || error;
