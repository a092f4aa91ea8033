// A simulated person sets up one scene through the modules of the page, without a browser:
// set_up.mjs FOLDER ADDRESS. FOLDER contains setup.json, the person's knowledge and clicks, and
// frozen.rgba, the frozen image. Writes the scene to FOLDER/saved, and prints {step, words}: where
// and why the page stopped, {asked}: its questions, {done}: the sentences of step 7.
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { crc32, deflateSync } from 'node:zlib';
import path from 'node:path';

const PAGE = path.resolve(import.meta.dirname, '../../../master/station/page'), load = (name) => import(path.join(PAGE, name));
const { distance, nearestOn } = await load('setup_geometry.js');
const { STEPS, angleAt, arcBetween, emptyAnswers, foundOf, isRound, mm, outlineOf, problemsAt, sceneOf, startOf, stepOfKey, toolPixelOf, viewOf } = await load('setup_scene.js');
const { findTip, greyOf, imageTrouble, ontoEdge } = await load('setup_tip.js');
const { questionsAt, sentencesOf } = await load('setup_questions.js');
const { callWords, mistakeWords } = await load('setup_text.js');

const OFF_PX = 2.5;  // rms error of an outline that a person would notice
const [folder, address, cameraText] = process.argv.slice(2);
const known = JSON.parse(readFileSync(path.join(folder, 'setup.json'), 'utf8')), [width, height] = known.size;
const image = { width, height, data: readFileSync(path.join(folder, 'frozen.rgba')) }, grey = greyOf(image);
const answers = emptyAnswers(), asked = [];
const end = (result) => {
  console.log(JSON.stringify({ asked, ...result }));
  process.exit(0);
};

async function call(name, step, request) {
  const response = await fetch(`${address}/setup/${name}`, { method: 'POST', body: JSON.stringify(request) }), reply = await response.json();
  if (!response.ok || reply.error) end({ step, words: [callWords(name, reply)], details: reply.error });
  return reply;
}

// Returns a part of the image as a colour PNG, with a table-driven CRC per chunk.
function png([[u0, v0], [u1, v1]]) {
  const [w, h] = [u1 - u0 + 1, v1 - v0 + 1], rows = Buffer.alloc(h * (1 + 3 * w));
  for (let v = 0; v < h; ++v)
    for (let u = 0; u < w; ++u) image.data.copy(rows, v * (1 + 3 * w) + 1 + 3 * u, 4 * ((v0 + v) * width + u0 + u), 4 * ((v0 + v) * width + u0 + u) + 3);
  const chunk = (name, data) => {
    const body = Buffer.concat([Buffer.from(name), data]), out = Buffer.alloc(body.length + 8);
    out.writeUInt32BE(data.length, 0);
    body.copy(out, 4);
    out.writeUInt32BE(crc32(body), body.length + 4);
    return out;
  };
  const head = Buffer.alloc(13);
  head.writeUInt32BE(w, 0);
  head.writeUInt32BE(h, 4);
  head.set([8, 2, 0, 0, 0], 8);
  return Buffer.concat([Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]), chunk('IHDR', head), chunk('IDAT', deflateSync(rows)), chunk('IEND', Buffer.alloc(0))]);
}

// Returns the rms distance of the drawn outline from the true edge [px].
const offEdge = (line) => Math.sqrt(line.reduce((sum, p) => sum + nearestOn(known.outline, p).distance ** 2, 0) / line.length);

// Answers the questions of a step. A person knows the sizes, sees the outline, and follows advice
// about the image.
async function answer(step) {
  for (;;) {
    const problems = problemsAt(step, answers);
    if (problems.length) end({ step, words: problems });
    const [question] = questionsAt(step, answers);
    if (!question) return;
    asked.push({ step, text: question.text });
    const isFollowed =
      (known.remedies.includes('tape') && /strip of tape/.test(question.text)) ||
      (known.remedies.includes('sheet') && /plain sheet/.test(question.text)) ||
      (known.remedies.includes('height') && /front edge/.test(question.text)) ||
      known.higher > Number(question.text.match(/at least (\S+) mm higher/)?.[1]);
    if (question.wrong === 'image' && !isFollowed) end({ step, words: [question.text], isAdvice: true });
    if (question.wrong === 'useClicks' && offEdge(answers.object.found) > OFF_PX) Object.assign(answers.object, { found: null, clear: null });
    else answers.confirmed.push(question.text);
  }
}

answers.image = { width, height, number: 1, trouble: imageTrouble(grey) };
await answer('image');
Object.assign(answers.scale, { points: known.scale, length: String(known.length), distance: String(known.distance) });
await answer('scale');
Object.assign(answers.object, { kind: known.kind, points: known.points, width: String(known.width), height: String(known.height), diameter: String(known.width), sides: known.sides, thickness: String(known.thickness), plane: known.plane });
const jpeg = readFileSync(path.join(folder, known.first)).toString('base64');
const outline = await call('outline', 'object', { image: jpeg, near: startOf(answers.object).map(([u, v]) => ({ u, v })) });
const edge = foundOf(answers.object, outline.outline.map(({ u, v }) => [u, v]));
Object.assign(answers.object, { found: isRound(answers.object) ? ontoEdge(grey, edge) : edge, clear: outline.clear ?? 0 });
const edgePx = offEdge(answers.object.found);
await answer('object');
answers.held = known.arcs.length ? [arcBetween(...known.arcs.map((p) => angleAt(answers, p)))] : [0];
await answer('held');
Object.assign(answers.material, { modulus: String(known.modulus), poisson: String(known.poisson), tolerance: '0' });
await answer('material');
Object.assign(answers.tool, { width: String(known.tool), shape: known.shape, by: known.by, depth: known.extent ? String(known.extent) : '', box: known.box });
answers.tool.seen = findTip(grey, known.box, outlineOf(answers), mm(answers.tool.width) / toolPixelOf(answers), known.shape === 'round', viewOf(answers));
await answer('tool');
for (const step of ['held', 'object']) await answer(step);
const { scene, files } = sceneOf(answers, cameraText.split('\n').filter(Boolean), png(answers.tool.seen.box));
mkdirSync(path.join(folder, 'saved'), { recursive: true });
for (const [name, bytes] of Object.entries({ ...files, 'scene.yaml': scene })) writeFileSync(path.join(folder, 'saved', name), bytes);
const base64 = Object.fromEntries(Object.entries(files).map(([name, bytes]) => [name, Buffer.from(bytes).toString('base64')]));
const reply = await call('propose', 'check', { scene, files: base64 });
if (reply.errors?.length) {
  const words = reply.errors.map(mistakeWords);
  end({ step: Object.keys(STEPS).find((step) => words.some(({ key }) => stepOfKey(key) === step)), words: words.map(({ text }) => text), details: words.map(({ details }) => details) });
}
if (!reply.contact) end({ step: 'check', words: ['no contact'], details: reply.report });
const { tip } = answers.tool.seen;
end({ done: sentencesOf(answers, reply.report).map(({ text }) => text), edgePx, tipPx: distance(tip, known.tip), roundness: answers.tool.seen.roundness, follow: answers.tool.seen.follow });
