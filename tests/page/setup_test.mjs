// Tests the set-up without a browser: geometry, the tip in an image, the scene, and wrong answers.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { test } from 'node:test';

// The tool is flat and seen from straight ahead unless a test states otherwise.
const AHEAD = { underside: 0, raised: 0, tilt: 0, upper: null, heightSigma: 1, levelSigma: 1 };
const tipIn = (grey, box, outline, width, isRound = false, view = AHEAD) => findTip(grey, box, outline, width, isRound, view);

const ROOT = path.resolve(import.meta.dirname, '../..'), PAGE = path.join(ROOT, 'master/station/page');
const load = (name) => import(path.join(PAGE, name));
const { bent, contains, crossesItself, crossingsWith, denser, fitCircle, fitRectangle, nearestOn, orderCorners, refineCorners, simplify } = await load('setup_geometry.js');
const { findTip, imageTrouble, ontoEdge, shiftOf } = await load('setup_tip.js');
const { HeldPress, fitModulus, modelProblem, newtons } = await load('setup_identify.js');
const { Answers, MATERIALS, PressCurve, STEPS, arcBetween, emptyAnswers, firstProblem, heldLines, pixelOf, pixelToleranceOf, problemsAt, runsOf, sceneOf, startOf, stepOfKey, toolPixelOf, undersideOf, viewOf } = await load('setup_scene.js');
const { firstOpen, questionsAt, sentencesOf } = await load('setup_questions.js');
const { quantity } = await load('setup_quantities.js');
const { callWords, mistakeWords } = await load('setup_text.js');
const { zipOf } = await load('save.js');

// A camera of 640 x 480 px at 0.35 mm/px whose centre is at (44, 54) mm, as in
// deploy/scenes/silicone-block.yaml.
const PIXEL = 0.35, toImage = ([x, y]) => [319.5 + (x - 44) / PIXEL, 239.5 - (y - 54) / PIXEL];
const BLOCK = [[0, 0], [88, 0], [88, 88], [0, 88]].map(toImage);
const noisy = (seed) => () => ((seed = (seed * 1103515245 + 12345) % 2147483648) / 2147483648 - 0.5);

// Draws the block and a flat tool of 5.87 mm whose end is at `tip` [px]. Each pixel is mixed by the
// covered part.
const drawn = new Map();
const draw = (...what) => drawn.get(JSON.stringify(what)) || drawn.set(JSON.stringify(what), paint(...what)).get(JSON.stringify(what));
function paint(tip, { block = 170, tool = 60, ground = 20, noise = 2, marks = 0, band = 0, far = [480, 0] } = {}) {
  const levels = new Float32Array(640 * 480), half = 5.87 / PIXEL / 2, random = noisy(1);
  const part = (low, high, i) => Math.max(0, Math.min(high, i + 0.5) - Math.max(low, i - 0.5));
  for (let v = 0; v < 480; ++v) {
    for (let u = 0; u < 640; ++u) {
      const inBlock = part(BLOCK[0][0], BLOCK[1][0], u) * part(BLOCK[2][1], BLOCK[0][1], v), inTool = part(tip[0] - half, tip[0] + half, u) * part(-1, tip[1], v);
      const behind = ground + part(far[0], 480, v) * (far[1] - ground), level = behind + inBlock * (block - behind), shade = tool + (Math.floor((tip[1] - v) / 6) % 2 ? marks : 0) + (tip[1] - v > 18 && tip[1] - v < 26 ? band : 0);
      levels[640 * v + u] = level + inTool * (shade - level) + noise * 2 * random();
    }
  }
  return { width: 640, height: 480, levels };
}

// Returns complete answers for the silicone block, with click errors of up to `off` px.
function blockAnswers(off = 0, found = null) {
  const random = noisy(7), click = (place) => place.map((value) => value + 2 * off * random()), answers = emptyAnswers();
  const tip = toImage([44, 94.2]), grey = draw(tip, { band: 60 });  // a strip of tape on the tool
  answers.image = { width: 640, height: 480, number: 1, trouble: imageTrouble(grey) };
  answers.scale = { ...answers.scale, points: [[0, 10], [100, 10]].map(toImage).map(click), length: '100', distance: '180' };
  answers.object = { ...answers.object, points: BLOCK.map(click), width: '88', height: '88', thickness: '9', found, clear: found ? 1 : null };
  answers.held = [0];
  answers.material = { ...answers.material, modulus: '127' };
  const box = [[tip[0] - 25, tip[1] - 60], [tip[0] + 25, tip[1] + 9]].map(click);
  answers.tool = { box, width: '5.87', shape: 'flat', by: 'whole', depth: '', seen: tipIn(grey, box, BLOCK, 5.87 / PIXEL) };
  return { answers, tip };
}
const edgeOf = (corners, random = noisy(3)) => corners.flatMap(([u, v], i) => Array.from({ length: 60 }, (_, k) => {
  const [a, b] = corners[(i + 1) % 4];
  return [u + ((k + 0.5) / 60) * (a - u) + 0.2 * random(), v + ((k + 0.5) / 60) * (b - v) + 0.2 * random()];
}));
const figures = (scene, key) => [...scene.match(new RegExp(`${key}: .*`))[0].matchAll(/-?[\d.]+(?= mm| px| rad|,|\])/g)].map(Number);

test('a rectangle is found again from its corners, turned and with clicks in any order', () => {
  const turn = 0.1, [c, s] = [Math.cos(turn), Math.sin(turn)], origin = [100, 400], size = [200, 120];
  const corners = [[0, 0], [200, 0], [200, 120], [0, 120]].map(([x, y]) => [origin[0] + c * x - s * y, origin[1] - s * x - c * y]);
  for (const clicks of [corners, [corners[2], corners[1], corners[0], corners[3]]]) {
    const fit = fitRectangle(orderCorners(clicks), size[0] * 1e-3, size[1] * 1e-3, 1e-3);
    assert.ok(Math.abs(fit.turn - turn) < 1e-9 && fit.misfit < 1e-9, JSON.stringify(fit));
    assert.ok(Math.hypot(fit.origin[0] - origin[0], fit.origin[1] - origin[1]) < 1e-9);
  }
});

test('clicks that are 3 px off come within 0.1 px of the corners by the edge, also where the tool hides a part', () => {
  const random = noisy(5), clicks = BLOCK.map((corner) => corner.map((value) => value + 6 * random()));
  const edge = edgeOf(BLOCK).map(([u, v]) => (Math.abs(u - 319) < 15 && v < 150 ? [u, v - 4] : [u, v]));
  refineCorners(clicks, edge).forEach((corner, i) => assert.ok(Math.hypot(corner[0] - BLOCK[i][0], corner[1] - BLOCK[i][1]) < 0.1, `${corner} for ${BLOCK[i]}`));
});

test('an outline that comes as its corners alone gives the corners, and one of short sides its circle', () => {
  const random = noisy(5), clicks = BLOCK.map((corner) => corner.map((value) => value + 6 * random()));
  refineCorners(clicks, denser(BLOCK, 3)).forEach((corner, i) => assert.ok(Math.hypot(corner[0] - BLOCK[i][0], corner[1] - BLOCK[i][1]) < 1e-6, `${corner}`));
  // Sides that are fitted to a circle of radius 100 cross it: half of each is inside, half outside.
  const corners = Array.from({ length: 26 }, (_, i) => [320 + 100.49 * Math.cos((i * Math.PI) / 13), 240 + 100.49 * Math.sin((i * Math.PI) / 13)]);
  assert.ok(Math.abs(fitCircle(denser(corners, 3)).radius - 100) < 0.2, `${fitCircle(denser(corners, 3)).radius}`);
});

test('a polygon about a bent edge comes onto the edge, and a square stays one', () => {
  // 26 sides, each half inside the circle of radius 100 as above, in either orientation.
  const corners = Array.from({ length: 26 }, (_, i) => [320 + 100.49 * Math.cos((i * Math.PI) / 13), 240 + 100.49 * Math.sin((i * Math.PI) / 13)]);
  for (const polygon of [corners, [...corners].reverse()]) {
    const off = denser(bent(polygon), 3).map(([u, v]) => Math.abs(Math.hypot(u - 320, v - 240) - 100)), before = denser(polygon, 3).map(([u, v]) => Math.abs(Math.hypot(u - 320, v - 240) - 100));
    // The remaining error is the height of an arc of half the length above its chord, a quarter of
    // 0.73 px.
    assert.ok(Math.max(...before) > 0.45 && Math.max(...off) < 0.19, `${Math.max(...before)} ${Math.max(...off)}`);
  }
  assert.ok(bent(BLOCK).every((p) => nearestOn(BLOCK, p).distance < 1e-9));
});

test('a bent outline that is 2 px off comes onto the edge in the image, also beside something that touches it', () => {
  const levels = new Float32Array(640 * 480).map((_, i) => {
    const [u, v] = [i % 640, Math.floor(i / 640)], inside = Math.min(1, Math.max(0, 100.5 - Math.hypot(u - 320, v - 240)));
    // A stick whose end touches the disc.
    return Math.abs(u - 320) < 4 && v < 140 ? 200 : 60 + 90 * inside;
  });
  const off = Array.from({ length: 210 }, (_, i) => (i * 2 * Math.PI) / 210).map((a) => [a, 100 + 2 * Math.sin(5 * a)]);
  const found = ontoEdge({ width: 640, height: 480, levels }, off.map(([a, r]) => [320 + r * Math.cos(a), 240 + r * Math.sin(a)]));
  const far = found.filter(([u, v]) => Math.abs(u - 320) > 12 || v > 200).map(([u, v]) => Math.abs(Math.hypot(u - 320, v - 240) - 100));
  assert.ok(Math.max(...far) < 0.25, `${Math.max(...far)}`);
  assert.ok(found.every(([u, v]) => Math.abs(Math.hypot(u - 320, v - 240) - 100) < 2.5));
});

test('a circle is fitted to an arc of it; points on a line have none', () => {
  const arc = [0, 0.5, 1, 1.5].map((angle) => [30 + 12 * Math.cos(angle), 40 + 12 * Math.sin(angle)]);
  const { centre, radius } = fitCircle(arc);
  assert.ok(Math.hypot(centre[0] - 30, centre[1] - 40) < 1e-9 && Math.abs(radius - 12) < 1e-9);
  assert.equal(fitCircle([[0, 0], [1, 1], [2, 2]]), null);
});

test('an outline is simplified without moving it, and a ray enters and leaves it', () => {
  const round = Array.from({ length: 200 }, (_, i) => [100 + 50 * Math.cos((i * Math.PI) / 100), 100 - 50 * Math.sin((i * Math.PI) / 100)]);
  const few = simplify(round, 0.5);
  assert.ok(few.length < 40 && round.every((p) => nearestOn(few, p).distance <= 0.5 + 1e-9), `${few.length}`);
  assert.ok(contains(few, [100, 100]) && !contains(few, [151, 100]) && !crossesItself(few));
  assert.ok(crossesItself([[0, 0], [10, 10], [10, 0], [0, 10]]));
  const [enters, leaves, ...more] = crossingsWith(round, [110, 0], [0, 1]).map(({ at }) => at), half = Math.sqrt(50 ** 2 - 10 ** 2);
  assert.ok(Math.abs(enters[1] - (100 - half)) < 0.1 && Math.abs(leaves[1] - (100 + half)) < 0.1 && enters[0] === 110 && !more.length);
  assert.deepEqual(crossingsWith(round, [200, 0], [0, 1]), []);
});

test('the tip is found within 0.1 px, wherever the box is, with and without marks', () => {
  for (const tip of [[319.5, 124.6], [300.2, 110.13], [351.77, 120.4]]) {
    for (const marks of [0, 30]) {
      for (const shift of [-4, 0, 4]) {
        const seen = tipIn(draw(tip, { marks }), [[tip[0] - 25 + shift, tip[1] - 60], [tip[0] + 25 + shift, tip[1] + 9]], BLOCK, 5.87 / PIXEL);
        assert.ok(!seen.why && Math.hypot(seen.tip[0] - tip[0], seen.tip[1] - tip[1]) < 0.1, JSON.stringify(seen));
        assert.ok(Math.abs(seen.width - 5.87 / PIXEL) < 0.3 && seen.beyond === (marks === 0), JSON.stringify(seen));
      }
    }
  }
});

// Draws the block with a tool that points along `d` and ends at `tip` [px].
function drawTilted(tip, d, isRound) {
  const half = 5.87 / PIXEL / 2, grey = draw([320, -50]), levels = Float32Array.from(grey.levels);
  for (let v = 0; v < 150; ++v) {
    for (let u = 200; u < 440; ++u) {
      let part = 0;  // part of the pixel that the tool covers
      for (let i = 0; i < 16; ++i) {
        const [x, y] = [u - tip[0] + ((i % 4) - 1.5) / 4, v - tip[1] + (Math.floor(i / 4) - 1.5) / 4], beside = Math.abs(x * d[1] - y * d[0]);
        const end = isRound ? Math.sqrt(Math.max(0, half * half - beside * beside)) - half : 0;
        if (x * d[0] + y * d[1] < end && beside < half) part += 1 / 16;
      }
      levels[640 * v + u] += part * (90 - 20);
    }
  }
  return { ...grey, levels };
}

test('the tip of a tilted tool is found with its direction', () => {
  for (const turn of [-0.26, 0.15, 0.26]) {
    const tip = [320.3, 120.6], d = [Math.sin(turn), Math.cos(turn)];
    const seen = tipIn(drawTilted(tip, d, false), [[tip[0] - 35, tip[1] - 60], [tip[0] + 35, tip[1] + 9]], BLOCK, 5.87 / PIXEL);
    assert.ok(!seen.why && Math.hypot(seen.tip[0] - tip[0], seen.tip[1] - tip[1]) < 0.3, `${turn}: ${JSON.stringify(seen)}`);
    assert.ok(Math.abs(seen.direction[0] - d[0]) < 0.02 && Math.abs(seen.width - 5.87 / PIXEL) < 0.4, `${turn}: ${JSON.stringify(seen)}`);
  }
});

test('the apex of a round tool is found, on average within 0.06 px', () => {
  const off = [-0.1, 0, 0.1].flatMap((turn) => [0, 0.25, 0.5, 0.75].map((part) => {
    const tip = [320.3, 120 + part], d = [Math.sin(turn), Math.cos(turn)];
    const seen = tipIn(drawTilted(tip, d, true), [[tip[0] - 35, tip[1] - 60], [tip[0] + 35, tip[1] + 9]], BLOCK, 5.87 / PIXEL, true);
    return (seen.tip[0] - tip[0]) * d[0] + (seen.tip[1] - tip[1]) * d[1];
  }));
  const mean = off.reduce((sum, value) => sum + value, 0) / off.length;
  // Without correction the arc across the used rows would shift it by 0.12 px.
  assert.ok(Math.abs(mean) < 0.06 && off.every((value) => Math.abs(value) < 0.2), `${off}`);
});

test('the tip is found before the far edge of an upper face', () => {
  for (const [tool, ground, face] of [[42, 88, 131], [42, 131, 88], [200, 60, 110]]) {
    for (const apart of [-0.7, 0.4, 1.3]) {
      const tip = [319.5, 124.4], grey = draw(tip, { tool, ground, far: [tip[1] + apart, face] });
      const seen = tipIn(grey, [[294, 64], [345, 133]], BLOCK, 5.87 / PIXEL);
      // Without blur, the place of an edge is known to a part of the pixel that both edges share.
      assert.ok(!seen.why && Math.abs(seen.tip[1] - tip[1]) < 0.35, `${tool} before ${ground}, ${face} from ${apart} px on: ${JSON.stringify(seen)}`);
    }
  }
});

// Reference: a pinhole 200 px before the front of a slab that is 12 px thick, at each height above its upper edge, level; the tool is
// 10 px above the edge. The found edge is that of the back where it is seen, and so is the tool's end.
test('what a camera at some height sees of tool and object beyond their fronts is taken off', () => {
  const [away, thick, gap] = [200, 12, 10], back = away / (away + thick), view = { underside: thick / (away + thick), raised: thick / (away + thick), heightSigma: 8, levelSigma: 2 };
  for (let height = -12; height <= 24; height += 2) {
    const edge = Math.min(height, height * back), end = Math.max(height - gap, (height - gap) * back), nearer = gap - (edge - end);
    const { shift, sigma } = shiftOf(view, 1, gap, height);
    assert.ok(Math.abs(shift - nearer) < 2 * sigma + 1e-9 && sigma < 0.15, `${height}: ${shift} ${sigma} for ${nearer}`);
  }
  // A camera that does not look level says nothing about its height.
  const { shift, sigma } = shiftOf(view, 1, gap, -100), middle = shiftOf({ ...view, levelSigma: 1e6 }, 1, gap, gap / 2);
  assert.ok(Math.abs(shift - middle.shift) < 1e-9 && sigma > 0.2, `${shift} ${sigma}`);
});

test('the scene of the silicone block is that of the hand-written one', () => {
  const { answers, tip } = blockAnswers(2, edgeOf(BLOCK));
  assert.equal(firstProblem(answers), null, JSON.stringify(Object.keys(STEPS).map((step) => problemsAt(step, answers))));
  const { scene, files } = sceneOf(answers, ['source: stream', 'rate: 60 Hz'], new Uint8Array([1]));
  assert.ok(Math.abs(pixelOf(answers) / 0.35e-3 - 1) < 0.002, `${pixelOf(answers)}`);
  const [x, y] = figures(scene, 'pose: \\{translation');
  assert.ok(Math.hypot(x - 44, y - 54) < 0.1, scene);
  const [u, v] = figures(scene, 'tip'), [low] = answers.tool.seen.box;
  assert.ok(Math.hypot(u + low[0] - tip[0], v + low[1] - tip[1]) < 0.1, scene);
  for (const words of ['rectangle: {width: 88 mm, height: 88 mm, thickness: 9 mm}', 'fixed: [{side: bottom}]', 'source: stream', 'manipulator: none', 'young_modulus: 127 kPa', 'depth: whole']) assert.ok(scene.includes(words), words);
  const [, right, up] = scene.match(/direction: \[(\S+), (\S+)\]/);
  assert.ok(Math.abs(right) < 0.01 && Number(up) < -0.999, scene);
  assert.deepEqual(Object.keys(files), ['tip.png']);
  const part = { ...answers, tool: { ...answers.tool, by: 'part', depth: '4' } };
  assert.ok(sceneOf(part, [], new Uint8Array([1])).scene.includes('depth: 4 mm'));
});

test('a disc and an outline hold arcs between two clicks, of any length', () => {
  const { answers } = blockAnswers(), round = Array.from({ length: 120 }, (_, i) => [320 + 100 * Math.cos((i * Math.PI) / 60), 240 - 100 * Math.sin((i * Math.PI) / 60)]);
  answers.object = { ...answers.object, kind: 'disc', points: [round[0], round[40], round[80]], diameter: '70', found: round, clear: 1 };
  const deg = Math.PI / 180, tool = answers.tool;
  answers.tool = { ...tool, seen: null };
  for (const kind of ['disc', 'outline']) {
    answers.object = { ...answers.object, kind };
    answers.held = [arcBetween(-45 * deg, -135 * deg)];
    assert.deepEqual(problemsAt('held', answers), []);
    const [[centre, half]] = [...sceneOf({ ...answers, tool }, [], null).scene.matchAll(/centre: (\S+) rad, half_angle: (\S+) rad/g)].map(([, ...values]) => values.map(Number));
    assert.ok(Math.abs(centre + Math.PI / 2) < 1e-6 && Math.abs(half - Math.PI / 4) < 1e-6, `${centre} ${half}`);
    const [line] = heldLines(answers);
    assert.ok(line.every(([u, v]) => v > 240 + 100 * Math.SQRT1_2 - 6 && Math.abs(u - 320) < 100 * Math.SQRT1_2 + 6) && line.length > 25, `${line.length}`);
    answers.held = [{ from: 0 }];
    assert.match(problemsAt('held', answers)[0], /other end/);
    answers.held = [{ from: 0, to: 6.25 }];
    assert.match(problemsAt('held', answers)[0], /All edges are held/);
  }
  const { scene, files } = sceneOf({ ...answers, tool }, [], null);
  assert.match(scene, /contour: outline.csv\n {4}thickness: 9 mm/);
  assert.equal(new TextDecoder().decode(files['outline.csv']).trim().split('\n').length, 121);
  assert.deepEqual(runsOf([0, 6, 11], 12), [[6, 6], [11, 0]]);
});

test('of a bar that is seen from below, the end of its front is found', () => {
  // A pinhole camera is 200 mm in front of a bar of 9 mm depth, at the height of the pressed edge,
  // 6 mm below the bar's end. The end of the bar's back, 209 mm away, appears lower than that of
  // its front, 200 mm away.
  const { answers } = blockAnswers(0, edgeOf(BLOCK)), edge = BLOCK[2][1], focal = 200 / 0.35, [front, back] = [200, 209].map((far) => edge - (6 * focal) / far);
  answers.scale.distance = '200';
  const box = [[294, back - 60], [345, back + 9]];
  for (const [tool, ground] of [[60, 110], [200, 110], [200, 20]]) {
    // The face of the end has 0.7 of the level of the front: the bar is drawn up to its back in
    // this level, and then its front.
    const bar = (end, level) => draw([319.5, end], { tool: level, ground }).levels, [far, near, shaded] = [bar(back, 0.7 * tool), bar(front, tool), bar(front, 0.7 * tool)];
    const grey = { width: 640, height: 480, levels: far.map((level, i) => level + near[i] - shaded[i]) };
    const { tip } = tipIn(grey, box, BLOCK, 5.87 / PIXEL, false, viewOf(answers));
    // Without blur the half level of a two-part step can be located only to a third of a pixel.
    assert.ok(back - front > 0.7 && Math.abs(tip[1] - front) < 0.3, `${tool} before ${ground}: ${tip[1]} for ${front}`);
  }
  // The front of a stick in the middle is behind that of the object, where a pixel covers more.
  Object.assign(answers.tool, { by: 'part', depth: '3' });
  assert.ok(Math.abs(undersideOf(answers) - 3 / 206) < 1e-9 && Math.abs(toolPixelOf(answers) / pixelOf(answers) - 203 / 200) < 1e-9);
});

test('a block takes the model of thick bodies, asks for a camera that sees the tip in it, and refuses a round end', () => {
  const { answers } = blockAnswers(0, edgeOf(BLOCK));
  Object.assign(answers.object, { thickness: '60', plane: 'block' });
  // It would look so wide if it were nearer.
  Object.assign(answers.tool, { by: 'part', depth: '6', width: '6.75' });
  assert.deepEqual(problemsAt('object', answers), []);
  assert.match(questionsAt('tool', answers)[0].text, /27 mm behind the front of the block.*at least 29\.3 mm higher/);
  const { scene } = sceneOf(answers, [], null);
  assert.match(scene, /model: \{kind: extruded, /);
  assert.match(scene, /distance: 180 mm/);
  assert.match(scene, /depth: 6 mm/);
  answers.tool.shape = 'round';
  assert.match(problemsAt('tool', answers)[0], /only a tool with a flat end/);
});

test('the far edge of its upper face shows how a camera before a block looks up or down', () => {
  // A pinhole with a focal length of 610 px, 40 mm higher than the edge of a block that is 60 mm deep, 305 mm away. The front of the
  // tool is 27 mm behind that of the block, its end 8 mm above it.
  const { answers } = blockAnswers(0, edgeOf(BLOCK)), seenAt = (high, far, turned) => 239.5 + 610 * (high / far + turned);
  Object.assign(answers.object, { thickness: '60', plane: 'block' });
  Object.assign(answers.tool, { by: 'part', depth: '6' });
  answers.scale.distance = '305';
  for (const turned of [-0.008, 0, 0.008]) {
    const [near, far, end] = [seenAt(40, 305, turned), seenAt(40, 365, turned), seenAt(32, 332, turned)], levels = new Float32Array(640 * 480), random = noisy(5);
    const part = (low, high, i) => Math.max(0, Math.min(high, i + 0.5) - Math.max(low, i - 0.5));
    for (let v = 0; v < 480; ++v) {
      for (let u = 0; u < 640; ++u) {
        const inObject = u > 200 && u < 440, behind = 125 + (inObject ? part(far, near, v) * (68 - 125) + part(near, 470, v) * (85 - 125) : 0);
        levels[640 * v + u] = behind + part(313.5, 325.5, u) * part(-1, end, v) * (45 - behind) + 4 * random();
      }
    }
    const outline = [[200, near], [440, near], [440, 470], [200, 470]];
    const { why, tip, sigma } = tipIn({ width: 640, height: 480, levels }, [[295, end - 60], [345, end + 8]], outline, 12, false, viewOf(answers));
    // The tip where a level camera would see it as far above the edge.
    const level = 239.5 + ((near - 239.5) * 305 - 8 * 610) / 332;
    assert.ok(!why && Math.abs(tip[1] - level) < 0.25 && sigma < 0.25, `${turned}: ${why} ${tip} for ${level}, sigma ${sigma}`);
  }
});

test('the edge of a disc is looked for near the circle through the clicks, however few they are', () => {
  const clicks = [0.3, 1.2, 2.6].map((angle) => [320 + 100 * Math.cos(angle), 240 + 100 * Math.sin(angle)]);
  const start = startOf({ kind: 'disc', points: clicks });
  assert.ok(start.length > 100 && start.every(([u, v]) => Math.abs(Math.hypot(u - 320, v - 240) - 100) < 1e-6));
  assert.deepEqual(startOf({ kind: 'outline', points: clicks }), clicks);
});

test('each wrong answer is reported at its step', () => {
  const with_ = (step, part) => {
    const { answers } = blockAnswers(0, edgeOf(BLOCK));
    answers[step] = step === 'held' ? part : { ...answers[step], ...part };
    return [answers, step];
  };
  const seen = (box, width = 5.87 / PIXEL, image = draw(toImage([44, 94.2]))) => tipIn(image, box, BLOCK, width), tip = toImage([44, 94.2]);
  const dark = draw(tip, { block: 30, tool: 25, ground: 20, noise: 1 });
  const cases = [
    [...with_('image', { trouble: imageTrouble(dark) }), /too dark/],
    [...with_('image', { trouble: imageTrouble({ ...dark, levels: dark.levels.map(() => 255) }) }), /too bright/],
    [...with_('image', { trouble: imageTrouble({ ...dark, levels: dark.levels.map(() => 128) }) }), /same brightness/],
    [...with_('scale', { points: [] }), /Click two marks/],
    [...with_('scale', { length: '0' }), /above 0/],
    [...with_('scale', { length: 'ten' }), /expected a number such as 8.8, in mm/],
    [...with_('scale', { points: [[10, 10], [10, 10]] }), /0 px apart/],
    [...with_('scale', { distance: '' }), /Distance from the lens to the front of the object: expected/],
    [...with_('scale', { length: '100000' }), /Give the length in mm/],
    [...with_('scale', { by: 'board', square: '' }), /Edge of a square: expected/],
    [...with_('scale', { by: 'board', square: '5', columns: '2' }), /Inner corners of the board/],
    [...with_('object', { points: BLOCK.slice(0, 3) }), /3 so far/],
    [...with_('object', { points: [BLOCK[0], BLOCK[2], BLOCK[1], BLOCK[3]], found: null }), /crosses itself/],
    [...with_('object', { points: BLOCK.map(([u]) => [u, 100]), found: null }), /encloses almost nothing/],
    [...with_('object', { width: '' }), /Width: expected/],
    [...with_('object', { width: '78' }), /The width is 78 mm, but .* 88 mm/],
    [...with_('object', { thickness: '-9' }), /Thickness: expected/],
    [...with_('object', { thickness: '88' }), /You chose "thin", but the thickness/],
    [...with_('object', { points: BLOCK.map(([u, v], i) => [u + (i > 1 ? 40 : 0), v]), found: null }), /form no rectangle/],
    [...with_('object', { clear: 0.3 }), /30 % of the outline/],
    [...with_('held', []), /Click the edges/],
    [...with_('held', [0, 1, 2, 3]), /All edges are held/],
    [...with_('material', { modulus: '' }), /Young's modulus: expected/],
    [...with_('material', { poisson: '0.6' }), /Poisson's ratio/],
    [...with_('material', { by: 'name' }), /Choose a material/],
    [...with_('tool', { width: '0' }), /Width of the tip/],
    [...with_('tool', { by: '' }), /how far the tool reaches through the thickness/],
    [...with_('tool', { by: 'part', depth: '' }), /in the direction of the thickness: expected/],
    [...with_('tool', { box: [] }), /Drag a box/],
    [...with_('tool', { seen: seen([[450, 60], [500, 130]]) }), /No tool is seen in the box/],
    [...with_('tool', { seen: seen([[tip[0] - 25, tip[1] - 60], [tip[0] + 25, tip[1] - 10]]) }), /end is not seen/],
    [...with_('tool', { seen: seen([[tip[0] - 25, 80], [tip[0] + 25, 170]], 5.87 / PIXEL, draw([tip[0], 155])) }), /must not touch/],
    [...with_('tool', { width: '9' }), /the image shows 5.8/],
  ];
  for (const [answers, step, words] of cases) {
    const reported = problemsAt(step, answers);
    assert.ok(reported.some((text) => words.test(text)), `${words}: ${JSON.stringify(reported)}`);
    assert.equal(firstProblem(answers), step, `${words}`);
  }
});

// Wrong but numeric answers of a person: each must be rejected or questioned before a force is
// shown. The right ones are: a block of 88 x 88 x 9 mm, 127 kPa, fixed at the bottom, pressed by a
// flat tool of 5.87 mm, with 100 mm of a ruler.
const cm = (mm) => String(mm / 10), inCm = (answers) => {
  Object.assign(answers.scale, { length: '10' });
  Object.assign(answers.object, { width: cm(88), height: cm(88), thickness: cm(9) });
  answers.tool.width = cm(5.87);
};
const seenRound = () => { const tip = toImage([44, 94.2]); return tipIn(drawTilted(tip, [0, 1], true), [[tip[0] - 25, tip[1] - 60], [tip[0] + 25, tip[1] + 9]], BLOCK, 5.87 / PIXEL, true); };
const WRONG = [
  ['thick for a slab', 'object', ({ object }) => { object.plane = 'strain'; }, /You chose "thick".*9 mm.*88 mm/],
  ['cm for mm everywhere', 'scale', inCm, /image would be 22\.\d mm wide/],
  ['m for mm everywhere', 'scale', (a) => { a.scale.length = '0.1'; Object.assign(a.object, { width: '0.088', height: '0.088', thickness: '0.009' }); a.tool.width = '0.00587'; }, /image would be 0\.22/],
  ['distance of the lens in cm', 'scale', ({ scale }) => { scale.distance = '18'; }, /18 mm away .* it would see 16[12] degrees/],
  ['distance of the lens as ten times as large', 'scale', ({ scale }) => { scale.distance = '1800'; }, /it would see 7 degrees/],
  ['thickness 0.9 for 9', 'object', ({ object }) => { object.thickness = '0.9'; }, /only 0\.9 mm thick/],
  ['thickness 1 for 10', 'object', ({ object }) => { object.thickness = '1'; }, /only 1 mm thick/],
  ['width and thickness exchanged', 'object', ({ object }) => { object.width = '9'; object.thickness = '88'; }, /The width is 9 mm, but/],
  ['thickness 62 for thin', 'object', ({ object }) => { object.thickness = '62'; }, /62 mm thick.*nearly a cube/],
  ['height of another object', 'object', ({ object }) => { object.height = '70'; }, /The height is 70 mm, but/],
  ['radius for width', 'object', ({ object }) => { object.width = '44'; }, /The width is 44 mm, but/],
  ['width in cm', 'object', ({ object }) => { object.width = '8.8'; }, /The width is 8.8 mm, but/],
  ['thickness with a separator of thousands', 'object', ({ object }) => { object.thickness = '9,000'; }, /could be 9\.000 or 9000/],
  ['a fraction', 'object', ({ object }) => { object.thickness = '1/2'; }, /expected a number/],
  ['thickness in another unit', 'object', ({ object }) => { object.thickness = '9 kPa'; }, /no unit of this field/],
  ['modulus in Pa', 'material', ({ material }) => { material.modulus = '127000'; }, /127000 kPa\. Is that right/],
  ['modulus in MPa', 'material', ({ material }) => { material.modulus = '0.127'; }, /0\.127 kPa\. Is that right/],
  ['modulus 60000', 'material', ({ material }) => { material.modulus = '60000'; }, /60000 kPa\. Is that right/],
  ['modulus with a separator', 'material', ({ material }) => { material.modulus = '1,234'; }, /could be 1\.234 or 1234/],
  ['modulus in hexadecimal digits', 'material', ({ material }) => { material.modulus = '0x3C'; }, /expected a number/],
  ["Poisson's ratio 49", 'material', ({ material }) => { material.poisson = '49'; }, /Poisson's ratio: expected/],
  ["Poisson's ratio 0.049", 'material', ({ material }) => { material.poisson = '0.049'; }, /0\.049\. Rubbers and gels/],
  ['uncertainty as a share', 'material', ({ material }) => { material.tolerance = '0.05'; }, /within 0\.05 %/],
  ['the pressed edge held, too', 'held', (a) => { a.held = [0, 2]; }, /would press an edge that you marked as held/],
  ['the pressed edge held alone', 'held', (a) => { a.held = [2]; }, /would press an edge that you marked as held/],
  ['the left edge held for the lower one', 'held', (a) => { a.held = [3]; }, /towards an edge that is not held/],
  ['round for flat', 'tool', ({ tool }) => { tool.shape = 'round'; }, /in the image it looks flat/],
  ['flat for round', 'tool', ({ tool }) => { tool.seen = seenRound(); }, /in the image it looks round/],
  ['diameter of the tool doubled', 'tool', ({ tool }) => { tool.width = '11.74'; }, /the image shows 5\.8/],
  ['tool in cm', 'tool', ({ tool }) => { tool.width = '0.587'; }, /the image shows 5\.8/],
  ['tool deeper than the object', 'tool', ({ tool }) => { tool.by = 'part'; tool.depth = '20'; }, /more than the thickness/],
  ['depth of the tool in cm', 'tool', ({ tool }) => { tool.by = 'part'; tool.depth = '0.6'; }, /0\.6 mm in the direction of the thickness/],
  ['a thin stick "through the whole" of a block of 60 mm', 'tool', ({ object, tool }) => { object.thickness = '40'; tool.by = 'whole'; }, /a bar of 5\.87 mm x 40 mm/],
  ['a stick in the middle, hidden by the front edge', 'tool', ({ tool }) => { tool.by = 'part'; tool.depth = '5.87'; }, /goes behind the front edge/],
  ['an outline that was pulled to something else', 'object', (a) => { Object.assign(a.object, { kind: 'outline', points: [...a.object.points.slice(0, 2), toImage([88, 44]), ...a.object.points.slice(2)], found: a.object.found.map(([u, v]) => [u + (u > 400 ? 25 : 0), v]) }); a.held = [arcBetween(-2.3, -0.8)]; }, /px from one of your clicks/],
];
test(`each of ${WRONG.length} wrong numbers is refused or asked about at its step`, () => {
  const right = () => structuredClone({ ...blockAnswers(0, denser(BLOCK, 3)).answers });
  assert.equal(firstOpen(right()), null, JSON.stringify(Object.keys(STEPS).map((step) => [problemsAt(step, right()), questionsAt(step, right())])));
  for (const [what, step, change, words] of WRONG) {
    const answers = right();
    change(answers);
    const texts = [...problemsAt(step, answers), ...questionsAt(step, answers).map(({ text }) => text)];
    assert.ok(texts.some((text) => words.test(text)), `${what}: ${JSON.stringify(texts)}`);
    assert.equal(firstOpen(answers), step, what);
    // A question that is answered with "right" is not asked again, unless a number changes; a problem stays.
    const asked = questionsAt(step, answers).map(({ text }) => text);
    answers.confirmed = asked;
    assert.deepEqual(questionsAt(step, answers), [], what);
  }
});

test('numbers are read with decimal commas and units, and refused where they could be two numbers', () => {
  const read = { '8.8': 8.8, '8,8': 8.8, ' 8,80 mm': 8.8, '0.88 cm': 8.8, '0,0088 m': 8.8, '8800 um': 8.8, '.5': 0.5, '0,123': 0.123, '-3': -3, '12,50': 12.5 };
  for (const [text, value] of Object.entries(read)) assert.ok(Math.abs(quantity(text, 'length').value - value) < 1e-12, text);
  assert.equal(quantity('60000 Pa', 'stress').value, 60);
  assert.equal(quantity('0.06 MPa', 'stress').value, 60);
  assert.equal(quantity('5 %', 'percent').value, 5);
  for (const text of ['1,234', '1.234,5', '1,234.5', '1 234', "1'234", '0x3C', '1/2', 'ten', '', '8.8 kg', '8 8', '3-4']) assert.ok(quantity(text, 'length').why, text);
});

test('a tip without marks is predicted to be lost where the object is much brighter than what is behind the tool, and marks cure it', () => {
  const tip = toImage([44, 94.2]), box = [[tip[0] - 25, tip[1] - 60], [tip[0] + 25, tip[1] + 9]];
  const lost = (levels) => tipIn(draw(tip, levels), box, BLOCK, 5.87 / PIXEL).follow.lost;
  // Levels of set-ups in which the tip was lost (226 in front of 105) or kept (about equal).
  assert.ok(lost({ block: 226, tool: 160, ground: 105 }));
  assert.ok(!lost({ block: 226, tool: 160, ground: 105, band: -80 }));
  assert.ok(!lost({ block: 140, tool: 60, ground: 120 }));
  assert.ok(!lost({ block: 222, tool: 120, ground: 222 }));
  const { answers } = blockAnswers(0, edgeOf(BLOCK));
  answers.tool.seen = tipIn(draw(tip, { block: 226, tool: 160, ground: 105 }), box, BLOCK, 5.87 / PIXEL);
  assert.match(questionsAt('tool', answers)[0].text, /brighter than what is behind the tool.*strip of tape/);
});

test('the set-up is stated in sentences, each with its step', () => {
  const { answers } = blockAnswers(0, edgeOf(BLOCK)), report = 'model     bem2d\nin words  rectangle 88 mm x 88 mm, 9 mm thick, about as stiff as silicone of Shore 00-50; 1 mm deep the tool presses with 0.27 N, the weight of 28 g\n';
  const words = sentencesOf(answers, report);
  assert.deepEqual(words.map(({ step }) => step), ['object', 'material', 'material', 'tool', 'held']);
  assert.equal(words[0].text, 'The object is 88 mm wide and 88 mm high, about as large as the palm of a hand, and 9 mm thick.');
  assert.equal(words[1].text, 'It is about as stiff as silicone of Shore 00-50.');
  assert.equal(words[2].text, '1 mm deep the tool presses with 0.27 N, the weight of 28 g.');
  assert.match(words[3].text, /flat end, 5\.87 mm wide, and reaches through the whole thickness of 9 mm/);
  assert.equal(words[4].text, 'Held: the lower edge.');
});

test('the tolerances contain what the last digits of thickness, width and sizes leave open', () => {
  const { answers } = blockAnswers(0, edgeOf(BLOCK)), tolerance = (changed) => Number(sceneOf(changed, [], null).scene.match(/tolerance: (\S+) %\}/)[1]);
  // A last digit of 1 mm is uniform within 1 mm: sigma 0.2887 mm of 9 mm, and 0.3 of that of 0.01 mm for the width of 5.87 mm.
  assert.ok(Math.abs(tolerance(answers) - Math.hypot(5, 28.868 / 9, 0.3 * 0.28868 / 5.87)) < 0.01, `${tolerance(answers)}`);
  const fine = { ...answers, object: { ...answers.object, thickness: '9.00' } };
  assert.ok(tolerance(fine) < 5.01, `${tolerance(fine)}`);
  assert.ok(tolerance({ ...answers, material: { ...answers.material, identified: '127' } }) === 5);
  const off = pixelToleranceOf(answers), coarse = pixelToleranceOf({ ...answers, object: { ...answers.object, width: '9 cm', height: '9 cm' } });
  assert.ok(Math.abs(Math.sqrt(coarse ** 2 - off ** 2) / (2.887 * Math.SQRT2 / 180) - 1) < 0.1, `${off} ${coarse}`);
});

test('errors of the slave become sentences without keys, and keep their text as details', () => {
  const reported = [
    [{ key: 'tool.width', value: '6 mm', message: 'another width than in the image', expected: '5.254 mm' }, 'tool', /looks 5\.254 mm wide.*but you gave 6 mm/],
    [{ key: 'sense.contour.start', message: "the contour collapsed, intersected itself or left its start (area 0.937988 of the start's): give another sense.contour.start or weights" }, 'object', /edge of the object is not found/],
    [{ key: 'object.geometry', message: 'the object in the first image is 4.5 % larger than in the scene', expected: '3 %: check camera.pixel (346.4 um would fit) and the sizes' }, 'object', /4\.5 % larger than you measured/],
    [{ key: 'sense.tip.template', message: 'the tool goes on beyond the tip', expected: 'an image of the end of the tool' }, 'tool', /drag a box/],
    [{ key: 'sense.tip', message: 'the tool touches the object in the image at the start, 0.5 mm deep', expected: 'an untouched object: lift the tool, or correct its tip' }, 'tool', /0\.5 mm deep: lift the tool/],
    [{ message: 'no new image within 2 s' }, 'image', /gives no image/],
    [{ message: 'something else' }, 'check', /The details say why/],
  ];
  for (const [error, step, form] of reported) {
    const { key, text, details } = mistakeWords(error);
    assert.match(text, form);
    assert.equal(stepOfKey(key), step, text);
    assert.ok(!/sense\.|object\.|camera\.|tool\./.test(text), text);
    assert.ok(details.includes(error.message));
  }
  assert.match(callWords('propose', { error: 'no answer in time', code: 'DEADLINE_EXCEEDED' }), /busy.*answers are kept/);
  assert.match(callWords('outline', { error: 'the slave has not answered in time: it is busy, or the link is cut', code: 'UNAVAILABLE' }), /busy, was ended, or the connection is cut/);
  assert.match(callWords('use', { error: '"ada" holds the lease', reason: 'LEASE_HELD' }), /Somebody operates/);
  assert.match(callWords('board', { error: 'none of 1 images shows a board of 9x6', reason: 'INVALID_FIELD' }), /board is not seen/);
  assert.match(callWords('outline', { error: 'the contour found no clear edge on most of its length: give another sense.contour.start', reason: 'INVALID_FIELD' }), /click nearer to the edge/);
  assert.match(callWords('image', { error: "role 'operator' may not call", reason: 'ROLE_NOT_ALLOWED' }), /--setup-tls/);
});

test('each step is undone alone, and a key of the scene has its step', () => {
  const answers = new Answers();
  answers.change('scale', { length: '10' });
  answers.change('object', { width: '5' });
  answers.change('scale', { length: '20' });
  answers.undo('scale');
  assert.deepEqual([answers.now.scale.length, answers.now.object.width], ['10', '5']);
  answers.undo('scale');
  answers.undo('scale');
  assert.deepEqual([answers.now.scale.length, answers.now.object.width, answers.canUndo('scale')], ['', '5', false]);
  const keys = { 'sense.camera.pixel': 'scale', 'sense.camera.device': 'image', 'object.geometry.rectangle.thickness': 'object', 'object.fixed': 'held', 'object.material.name': 'material', 'sense.tip.template': 'tool', 'tool.width': 'tool', name: 'check' };
  for (const [key, step] of Object.entries(keys)) assert.equal(stepOfKey(key), step, key);
});

test('before a touch the curve states what would not be seen', () => {
  const model = { reference: { x: 0, y: 0.088, z: 0 }, normal: { x: 0, y: 1, z: 0 }, in_contact: false, stiffness: [100, 0, 0, 0, 270, 0, 0, 0, 0] };
  const point = new PressCurve().add({ sequence: '1', validity: 'VALIDITY_VALID', sigma: 0, force: { x: 0, y: 0, z: 0 }, p_S_tip: { x: 0, y: 0.09, z: 0 }, local_model: model }, 0.35e-3);
  assert.ok(!point.isTouching && Math.abs(point.unseen - 0.5 * 0.35e-3 * 270) < 1e-12, JSON.stringify(point));
});

test('the curve takes depth along the surface normal and the largest valid depth', () => {
  const curve = new PressCurve(), state = (sequence, y, validity) => ({ sequence, validity, sigma: 0.1, force: { x: 0, y: 0.3, z: 0.4 }, p_S_tip: { x: 0, y, z: 0 }, local_model: { reference: { x: 0, y: 0.088, z: 0 }, normal: { x: 0, y: 1, z: 0 }, in_contact: true } });
  const point = curve.add(state('1', 0.086, 'VALIDITY_VALID'));
  assert.ok(Math.abs(point.depth - 0.002) < 1e-12 && Math.abs(point.force - 0.5) < 1e-12);
  assert.equal(curve.add(state('1', 0.08, 'VALIDITY_VALID')), null);
  curve.add(state('2', 0.08, 'VALIDITY_EXTRAPOLATED'));
  assert.ok(Math.abs(curve.largestValid - 0.002) < 1e-12);
});

// Makes presses with a guessed modulus of 100 kPa: the scale shows `factor` times the estimated
// force [N].
const pressed = (factor, { off = () => 0, sigma = 0, forces = [0.2, 0.5, 0.9, 1.4, 2] } = {}) =>
  forces.map((force) => ({ force, sigma: sigma * force, modulus: 1e5, reading: factor * force + off() }));

test('readings of a scale give the modulus, with the interval of a regression through zero', () => {
  // Reference: numpy.linalg.lstsq with these five points and t(0.975, 4) = 2.7764, in units of the
  // guess.
  const y = [0.31, 0.74, 1.36, 2.12, 2.98], readings = pressed(1).map((press, i) => ({ ...press, reading: y[i] }));
  const { modulus, half, tolerance, warnings } = fitModulus(readings, 1e-3);
  assert.ok(Math.abs(modulus / 1e5 - 1.49915) < 1e-4 && Math.abs(half / 1e5 - 0.017288) < 1e-4, `${modulus} ${half}`);
  assert.ok(Math.abs(tolerance - half / 1.96 / modulus) < 1e-9);
  assert.deepEqual(warnings, []);
  assert.ok(Math.abs(newtons('153', 'g') - 1.50042) < 1e-5 && newtons('1,5', 'N') === 1.5 && Number.isNaN(newtons('', 'g')));
});

test('95 of 100 intervals contain the modulus, whatever the readings, and rounding by the scale and a common error are in it', () => {
  let [inside, bad] = [0, 0];
  const random = noisy(11), normal = () => Array.from({ length: 12 }, random).reduce((total, value) => total + value, 0);
  for (let i = 0; i < 2000; ++i) {
    const { modulus, half } = fitModulus(pressed(1.3, { off: () => 0.02 * normal(), forces: [0.3, 0.5, 0.8, 1.1, 1.7, 2.2].slice(0, 3 + (i % 4)) }), 1e-3);
    inside += Math.abs(modulus - 1.3e5) <= half;
    const step = 0.05, common = 1 + 0.02 * normal();  // all forces have the same relative error
    const rounded = pressed(1.3).map((press) => ({ ...press, force: press.force * common, sigma: 0.02 * press.force, reading: step * Math.round(press.reading / step) }));
    const fit = fitModulus(rounded, step);
    bad += Math.abs(fit.modulus - 1.3e5) > fit.half;
  }
  assert.ok(inside > 1870 && inside < 1930 && bad < 100, `${inside} of 2000, ${bad} outside`);
});

test('readings that cannot be right are reported', () => {
  const all = (readings, resolution = 1e-3) => fitModulus(readings, resolution).warnings.join(' ');
  assert.equal(all(pressed(1.2)), '');
  assert.match(all(pressed(1.2).slice(0, 3)), /3 readings: take at least 5/);
  assert.match(all(pressed(102)), /102 times the first guess: is the unit/);
  assert.match(all(pressed(1.2, { off: () => 0.4 })), /Without a press the scale would show 0.4 N/);
  assert.match(all(pressed(1.2).map((press, i) => (i === 3 ? { ...press, reading: 1.68 / 9.80665e-3 } : press))), /Reading 4 does not fit/);
  assert.match(all(pressed(1.2, { forces: [1, 1.1, 1.2, 1.3, 1.4] })), /equally deep/);
  assert.match(all(pressed(1.2).map((press, i) => ({ ...press, reading: press.reading + [0.3, -0.3, 0.2, -0.2, 0.1][i] * 0.8 }))), /% off a line through zero/);
  assert.equal(fitModulus(pressed(1.2).slice(0, 1), 1e-3), null);
  assert.equal(modelProblem('bem2d'), '');
  assert.equal(modelProblem('extruded'), '');
  assert.match(modelProblem('membrane'), /The model membrane is not linear/);
});

test('a held press is the median of half a second of valid forces', () => {
  const held = new HeldPress(), point = (force, valid = true) => ({ force, depth: force / 1000, sigma: 0.01, valid });
  assert.match(held.take(0).why, /does not press/);
  for (let at = 0; at < 1000; at += 100) held.add(point(at < 500 ? 9 : 1 + at / 1e4, at !== 700), at);
  const { force, depth } = held.take(950);
  assert.ok(force > 1.05 && force < 1.1 && depth === force / 1000, `${force}`);
  for (let at = 1000; at < 1600; at += 100) held.add(point(1, false), at);
  assert.match(held.take(1600).why, /flagged/);
});

test('the list of materials is that of the table, and a zip file holds what it was given', () => {
  const rows = readFileSync(path.join(ROOT, 'deploy/scenes/materials.md'), 'utf8').split('\n').filter((line) => /^\| [a-z]+-/.test(line)).map((line) => line.split(' | ')[0].slice(2));
  assert.deepEqual(MATERIALS, rows);
  const folder = mkdtempSync(path.join(tmpdir(), 'palpate-zip-')), file = path.join(folder, 'a.zip');
  writeFileSync(file, zipOf({ 'a.yaml': new TextEncoder().encode('name: a\n'), 'b.bin': new Uint8Array([0, 255, 1]) }));
  const print = "import sys, zipfile; z = zipfile.ZipFile(sys.argv[1]); assert z.testzip() is None; print([(n, z.read(n)) for n in z.namelist()])";
  assert.equal(execFileSync('/usr/bin/python3', ['-c', print, file], { encoding: 'utf8' }).trim(), "[('a.yaml', b'name: a\\n'), ('b.bin', b'\\x00\\xff\\x01')]");
});
