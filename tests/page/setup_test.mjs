// The set-up's answers without a browser: geometry, the tip in an image, the scene, and wrong answers.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { test } from 'node:test';

const ROOT = path.resolve(import.meta.dirname, '../..'), PAGE = path.join(ROOT, 'master/station/page');
const load = (name) => import(path.join(PAGE, name));
const { contains, crossesItself, denser, divideAt, fitCircle, fitRectangle, nearestOn, orderCorners, refineCorners, simplify } = await load('setup_geometry.js');
const { findTip, imageTrouble } = await load('setup_tip.js');
const { HeldPress, fitModulus, modelProblem, newtons } = await load('setup_identify.js');
const { Answers, MATERIALS, PressCurve, STEPS, emptyAnswers, firstProblem, pixelOf, problemsAt, runsOf, sceneOf, stepOfKey } = await load('setup_scene.js');
const { zipOf } = await load('save.js');

// A camera of 640 x 480 px at 0.35 mm/px whose centre is at (44, 54) mm, as deploy/scenes/silicone-block.yaml has it.
const PIXEL = 0.35, toImage = ([x, y]) => [319.5 + (x - 44) / PIXEL, 239.5 - (y - 54) / PIXEL];
const BLOCK = [[0, 0], [88, 0], [88, 88], [0, 88]].map(toImage);
const noisy = (seed) => () => ((seed = (seed * 1103515245 + 12345) % 2147483648) / 2147483648 - 0.5);

// An image of the block and a flat tool of 5.87 mm whose end is at `tip` [px]: each pixel by the part of it that they cover.
const drawn = new Map();
const draw = (...what) => drawn.get(JSON.stringify(what)) || drawn.set(JSON.stringify(what), paint(...what)).get(JSON.stringify(what));
function paint(tip, { block = 170, tool = 60, ground = 20, noise = 2, marks = 0 } = {}) {
  const levels = new Float32Array(640 * 480), half = 5.87 / PIXEL / 2, random = noisy(1);
  const part = (low, high, i) => Math.max(0, Math.min(high, i + 0.5) - Math.max(low, i - 0.5));
  for (let v = 0; v < 480; ++v) {
    for (let u = 0; u < 640; ++u) {
      const inBlock = part(BLOCK[0][0], BLOCK[1][0], u) * part(BLOCK[2][1], BLOCK[0][1], v), inTool = part(tip[0] - half, tip[0] + half, u) * part(-1, tip[1], v);
      const level = ground + inBlock * (block - ground), shade = tool + (Math.floor((tip[1] - v) / 6) % 2 ? marks : 0);
      levels[640 * v + u] = level + inTool * (shade - level) + noise * 2 * random();
    }
  }
  return { width: 640, height: 480, levels };
}

// Complete answers of the silicone block, with clicks that are off by up to `off` px.
function blockAnswers(off = 0, found = null) {
  const random = noisy(7), click = (place) => place.map((value) => value + 2 * off * random()), answers = emptyAnswers();
  const tip = toImage([44, 94.2]), grey = draw(tip);
  answers.image = { width: 640, height: 480, number: 1, trouble: imageTrouble(grey) };
  answers.scale = { ...answers.scale, points: [[0, 10], [100, 10]].map(toImage).map(click), length: '100' };
  answers.object = { ...answers.object, points: BLOCK.map(click), width: '88', height: '88', thickness: '9', found, clear: found ? 1 : null };
  answers.held = [0];
  answers.material = { ...answers.material, modulus: '127' };
  const box = [[tip[0] - 25, tip[1] - 60], [tip[0] + 25, tip[1] + 9]].map(click);
  answers.tool = { box, width: '5.87', shape: 'flat', by: 'whole', depth: '', seen: findTip(grey, box, BLOCK, 5.87 / PIXEL) };
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
  // Sides that are fitted to a circle of radius 100 cross it: half of each lies within it, half without.
  const corners = Array.from({ length: 26 }, (_, i) => [320 + 100.49 * Math.cos((i * Math.PI) / 13), 240 + 100.49 * Math.sin((i * Math.PI) / 13)]);
  assert.ok(Math.abs(fitCircle(denser(corners, 3)).radius - 100) < 0.2, `${fitCircle(denser(corners, 3)).radius}`);
});

test('a circle is fitted to an arc of it; points on a line have none', () => {
  const arc = [0, 0.5, 1, 1.5].map((angle) => [30 + 12 * Math.cos(angle), 40 + 12 * Math.sin(angle)]);
  const { centre, radius } = fitCircle(arc);
  assert.ok(Math.hypot(centre[0] - 30, centre[1] - 40) < 1e-9 && Math.abs(radius - 12) < 1e-9);
  assert.equal(fitCircle([[0, 0], [1, 1], [2, 2]]), null);
});

test('an outline is divided at clicks and simplified without moving it', () => {
  const round = Array.from({ length: 200 }, (_, i) => [100 + 50 * Math.cos((i * Math.PI) / 100), 100 - 50 * Math.sin((i * Math.PI) / 100)]);
  const parts = divideAt(round, [[150, 100], [100, 50], [50, 100], [100, 150]]);
  assert.equal(parts.length, 4);
  parts.forEach((part, i) => assert.ok(Math.hypot(part.at(-1)[0] - parts[(i + 1) % 4][0][0], part.at(-1)[1] - parts[(i + 1) % 4][0][1]) < 1e-9));
  const few = simplify(round, 0.5);
  assert.ok(few.length < 40 && round.every((p) => nearestOn(few, p).distance <= 0.5 + 1e-9), `${few.length}`);
  assert.ok(contains(few, [100, 100]) && !contains(few, [151, 100]) && !crossesItself(few));
  assert.ok(crossesItself([[0, 0], [10, 10], [10, 0], [0, 10]]));
});

test('the tip is found within 0.1 px, wherever the box is, with and without marks', () => {
  for (const tip of [[319.5, 124.6], [300.2, 110.13], [351.77, 120.4]]) {
    for (const marks of [0, 30]) {
      for (const shift of [-4, 0, 4]) {
        const seen = findTip(draw(tip, { marks }), [[tip[0] - 25 + shift, tip[1] - 60], [tip[0] + 25 + shift, tip[1] + 9]], BLOCK, 5.87 / PIXEL);
        assert.ok(!seen.why && Math.hypot(seen.tip[0] - tip[0], seen.tip[1] - tip[1]) < 0.1, JSON.stringify(seen));
        assert.ok(Math.abs(seen.width - 5.87 / PIXEL) < 0.3 && seen.beyond === (marks === 0), JSON.stringify(seen));
      }
    }
  }
});

// The block's image with a tool that points along `d`, its end at `tip` [px].
function drawTilted(tip, d, isRound) {
  const half = 5.87 / PIXEL / 2, grey = draw([320, -50]), levels = Float32Array.from(grey.levels);
  for (let v = 0; v < 150; ++v) {
    for (let u = 200; u < 440; ++u) {
      let part = 0;  // of the pixel that the tool covers
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
    const seen = findTip(drawTilted(tip, d, false), [[tip[0] - 35, tip[1] - 60], [tip[0] + 35, tip[1] + 9]], BLOCK, 5.87 / PIXEL);
    assert.ok(!seen.why && Math.hypot(seen.tip[0] - tip[0], seen.tip[1] - tip[1]) < 0.3, `${turn}: ${JSON.stringify(seen)}`);
    assert.ok(Math.abs(seen.direction[0] - d[0]) < 0.02 && Math.abs(seen.width - 5.87 / PIXEL) < 0.4, `${turn}: ${JSON.stringify(seen)}`);
  }
});

test('the apex of a round tool is found, on average within 0.06 px', () => {
  const off = [-0.1, 0, 0.1].flatMap((turn) => [0, 0.25, 0.5, 0.75].map((part) => {
    const tip = [320.3, 120 + part], d = [Math.sin(turn), Math.cos(turn)];
    const seen = findTip(drawTilted(tip, d, true), [[tip[0] - 35, tip[1] - 60], [tip[0] + 35, tip[1] + 9]], BLOCK, 5.87 / PIXEL, true);
    return (seen.tip[0] - tip[0]) * d[0] + (seen.tip[1] - tip[1]) * d[1];
  }));
  const mean = off.reduce((sum, value) => sum + value, 0) / off.length;
  // The arc alone, as wide as the rows that are taken, would move it by 0.12 px.
  assert.ok(Math.abs(mean) < 0.06 && off.every((value) => Math.abs(value) < 0.2), `${off}`);
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

test('a disc and an outline hold arcs that contain the held parts and no others', () => {
  const { answers } = blockAnswers(), round = Array.from({ length: 120 }, (_, i) => [320 + 100 * Math.cos((i * Math.PI) / 60), 240 - 100 * Math.sin((i * Math.PI) / 60)]);
  answers.object = { ...answers.object, kind: 'disc', points: [round[0], round[40], round[80]], diameter: '70', found: round, clear: 1 };
  answers.held = [11, 0, 6].sort((a, b) => a - b);
  assert.deepEqual(runsOf(answers.held, 12), [[6, 6], [11, 0]]);
  assert.deepEqual(problemsAt('held', answers), []);
  const arcs = [...sceneOf(answers, [], null).scene.matchAll(/centre: (\S+) rad, half_angle: (\S+) rad/g)].map(([, ...values]) => values.map(Number));
  assert.ok(Math.abs(arcs[0][0] - (13 * Math.PI) / 12 + 2 * Math.PI) < 1e-6 && Math.abs(arcs[0][1] - Math.PI / 12) < 1e-6, `${arcs}`);
  assert.ok(Math.abs(arcs[1][0]) < 1e-6 && Math.abs(arcs[1][1] - Math.PI / 6) < 1e-6, `${arcs}`);
  answers.object = { ...answers.object, kind: 'outline' };
  answers.held = [1];
  assert.deepEqual(problemsAt('held', answers), []);
  const { scene, files } = sceneOf(answers, [], null);
  assert.match(scene, /contour: outline.csv\n {4}thickness: 9 mm/);
  assert.equal(new TextDecoder().decode(files['outline.csv']).trim().split('\n').length, 121);
});

test('each wrong answer is reported at its step', () => {
  const with_ = (step, part) => {
    const { answers } = blockAnswers(0, edgeOf(BLOCK));
    answers[step] = step === 'held' ? part : { ...answers[step], ...part };
    return [answers, step];
  };
  const seen = (box, width = 5.87 / PIXEL, image = draw(toImage([44, 94.2]))) => findTip(image, box, BLOCK, width), tip = toImage([44, 94.2]);
  const dark = draw(tip, { block: 30, tool: 25, ground: 20, noise: 1 });
  const cases = [
    [...with_('image', { trouble: imageTrouble(dark) }), /too dark/],
    [...with_('image', { trouble: imageTrouble({ ...dark, levels: dark.levels.map(() => 255) }) }), /too bright/],
    [...with_('image', { trouble: imageTrouble({ ...dark, levels: dark.levels.map(() => 128) }) }), /same brightness/],
    [...with_('scale', { points: [] }), /Click two marks/],
    [...with_('scale', { length: '0' }), /above 0/],
    [...with_('scale', { length: 'ten' }), /above 0/],
    [...with_('scale', { points: [[10, 10], [10, 10]] }), /0 px apart/],
    [...with_('scale', { length: '100000' }), /Give the length in mm/],
    [...with_('scale', { by: 'board', square: '' }), /Edge of a square: expected/],
    [...with_('scale', { by: 'board', square: '5', columns: '2' }), /Inner corners of the board/],
    [...with_('object', { points: BLOCK.slice(0, 3) }), /3 so far/],
    [...with_('object', { points: [BLOCK[0], BLOCK[2], BLOCK[1], BLOCK[3]], found: null }), /crosses itself/],
    [...with_('object', { points: BLOCK.map(([u]) => [u, 100]), found: null }), /encloses almost nothing/],
    [...with_('object', { width: '' }), /Width: expected/],
    [...with_('object', { width: '78' }), /The width is 78 mm, but .* 88 mm/],
    [...with_('object', { thickness: '-9' }), /Thickness: expected/],
    [...with_('object', { thickness: '88' }), /thickness is measured towards the camera/],
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

test('the curve takes depth along the surface normal and the largest valid depth', () => {
  const curve = new PressCurve(), state = (sequence, y, validity) => ({ sequence, validity, sigma: 0.1, force: { x: 0, y: 0.3, z: 0.4 }, p_S_tip: { x: 0, y, z: 0 }, local_model: { reference: { x: 0, y: 0.088, z: 0 }, normal: { x: 0, y: 1, z: 0 }, in_contact: true } });
  const point = curve.add(state('1', 0.086, 'VALIDITY_VALID'));
  assert.ok(Math.abs(point.depth - 0.002) < 1e-12 && Math.abs(point.force - 0.5) < 1e-12);
  assert.equal(curve.add(state('1', 0.08, 'VALIDITY_VALID')), null);
  curve.add(state('2', 0.08, 'VALIDITY_EXTRAPOLATED'));
  assert.ok(Math.abs(curve.largestValid - 0.002) < 1e-12);
});

// Presses with a modulus that was guessed as 100 kPa: what the scale shows is `factor` times the estimated force [N].
const pressed = (factor, { off = () => 0, sigma = 0, forces = [0.2, 0.5, 0.9, 1.4, 2] } = {}) =>
  forces.map((force) => ({ force, sigma: sigma * force, modulus: 1e5, reading: factor * force + off() }));

test('readings of a scale give the modulus, with the interval of a regression through zero', () => {
  // By numpy.linalg.lstsq of these five points and t(0.975, 4) = 2.7764, in units of the guess.
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
    const step = 0.05, common = 1 + 0.02 * normal();  // each force is off by the same share
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
