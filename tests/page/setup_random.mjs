// Sets up N random simulated scenes by clicks with errors of 2 px: objects are pressed by hand,
// with tilt, tremor, drift, automatic exposure, a passing shadow, irregular intervals and an
// uncorrected lens. Compares the forces with the simulator's true ones.
//
//   PALPATE_BIN=build/release/bin PALPATE_SCRATCH=build/page-test node tests/page/setup_random.mjs [N] [SEED]
//
// PALPATE_SCRATCH holds playwright-core, as tests/page/run.sh installs it. Prints a line for each scene, then how many met the limits.
import { mkdirSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { Person, cameraOf, compare, imagesOf, processSaved, trueStatesOf, uniform } from './setup_person.mjs';
import { SCRATCH, until } from './stage.mjs';

const LIMIT = 0.1, MAX_S = 60;  // rms error relative to the peak; time at the page
const [count, seed] = [Number(process.argv[2] || 12), Number(process.argv[3] || 1)];

// Makes a scene of random size, shape, stiffness and view: its text and the person's knowledge.
// Lengths in mm.
function randomScene(random, i) {
  const within = (low, high, digits = 1) => Number((low + (high - low) * random()).toFixed(digits));
  const kind = ['rectangle', 'disc', 'polygon'][i % 3], width = within(30, 140), height = kind === 'disc' ? width : within(0.6 * width, 1.2 * width), larger = Math.max(width, height);
  const known = { kind, width, height, thickness: within(0.05 * larger, 0.12 * larger), modulus: within(15, 500), poisson: within(0.3, 0.49, 2), tool: within(0.06 * larger, 0.1 * larger, 2), round: random() < 0.3 };
  const low = kind === 'disc' ? [-width / 2, -width / 2] : [0, 0], pixel = larger / within(190, 260, 3), centre = [low[0] + width / 2 + within(-0.1, 0.1, 3) * width, low[1] + height / 2 + 0.14 * larger];
  const slope = within(0.05, 0.2, 3) * width, corners = [[0, 0], [width, 0], [width - slope, height], [slope, height]];
  const shapes = {
    rectangle: `rectangle: {width: ${width} mm, height: ${height} mm, thickness: ${known.thickness} mm}`, disc: `disc: {radius: ${width / 2} mm, thickness: ${known.thickness} mm}`,
    polygon: `polygon: {points: [${corners.map(([x, y]) => `[${x} mm, ${y} mm]`).join(', ')}], thickness: ${known.thickness} mm}`,
  };
  const held = { rectangle: '{side: bottom}', disc: '{arc: {centre: -90 deg, half_angle: 60 deg}}', polygon: '{plane: {axis: y, at: 0}}' }[kind];
  const hand = `{tilt: ${within(5, 15)} deg, tremor: ${within(0.05, 0.3, 2)} mm, exposure: ${within(0.05, 0.2, 2)}, shadow: ${within(0.05, 0.3, 2)}, jitter: 0.3, lens: ${within(-0.01, 0.01, 4)}}`;
  const shift = [within(-0.02, 0.02, 4) * width, within(-0.02, 0.02, 4) * width];
  const text = `name: random-${i}
object:
  geometry:
    ${shapes[kind]}
  material: {young_modulus: ${known.modulus} kPa, poisson_ratio: ${known.poisson}, tolerance: 5 %}
  fixed: ${held}
tool: {shape: ${known.round ? 'round' : 'flat'}, width: ${known.tool} mm, depth: whole}
sense:
  camera: {source: simulated, rate: 30 Hz, size: [640, 480], pixel: ${pixel} mm, pose: {translation: [${centre[0]} mm, ${centre[1]} mm, 0]}}
  tip: {track: template}
  contour: {track: snake}
model: {kind: bem2d, plane: stress, tolerance: 10 %}
site: {seed: ${i + 1}, noise: ${within(1, 4)}, blur: ${within(0.5, 1.3)} px, lighting: ${within(0, 0.3, 2)}, misplacement: [${shift[0]} mm, ${shift[1]} mm], hand: ${hand}}
`;
  const toImage = cameraOf({ pixel, centre }), top = low[1] + height, moved = ([x, y]) => toImage([x + shift[0], y + shift[1]]);
  const home = toImage([low[0] + width / 2, top + 0.07 * larger]);
  return { text, known: { ...known, corners: (kind === 'polygon' ? corners : [[0, 0], [width, 0], [width, height], [0, height]]).map(moved), moved, toImage, home, px: known.tool / pixel } };
}

async function setUp(person, { kind, width, height, thickness, modulus, poisson, tool, round, corners, moved, toImage, home, px }) {
  const { page } = person;
  await person.freezeAtRest(home);
  await person.next();
  await person.click(toImage([0, 0]));
  await person.click(toImage([width, 0]));
  await person.fillScale(width);
  await person.next();
  await person.choose('object.kind', kind);
  if (kind === 'rectangle') {
    await person.fill('object.width', width);
    await person.fill('object.height', height);
  }
  if (kind === 'disc') await person.fill('object.diameter', width);
  await person.fill('object.thickness', thickness);
  const around = kind === 'disc' ? [0.3, 1.4, 2.8, 4, 5.3].map((angle) => moved([(width / 2) * Math.cos(angle), (width / 2) * Math.sin(angle)])) : corners;
  for (const place of around) await person.click(place);
  if (kind !== 'rectangle') await page.click('#setup-pull');
  await person.shows('setup-object-fact', /clear edge/);
  await person.next();
  const held = kind === 'disc' ? [210, 330].map((angle) => moved([(width / 2) * Math.cos((angle * Math.PI) / 180), (width / 2) * Math.sin((angle * Math.PI) / 180)])) : [moved([width / 2, 0])];
  for (const place of held) await person.click(place);
  await person.next();
  await person.fill('material.modulus', modulus);
  await person.fill('material.poisson', poisson);
  await person.fill('material.tolerance', 0);
  await page.click('#setup-questions [data-answer=right]');
  await person.next();
  await person.fill('tool.width', tool);
  await person.choose('tool.by', 'whole');
  if (round) await person.choose('tool.shape', 'round');
  await person.boxTip(home, px);
  await person.shows('setup-tool-fact', /^Tip found at/);
  await person.next();
  await person.confirmAll();
  await page.click('#setup-use');
  await person.shows('setup-force', /^[\d.]+ N/);
}

let met = 0;
const all = [0, 0, 0];  // numbers of states: in contact, within one sigma, within two sigma
const random = uniform(seed);
for (let i = 0; i < count; ++i) {
  const { text, known } = randomScene(random, i), folder = path.join(SCRATCH, `random-${seed}-${i}`), saved = path.join(folder, 'saved');
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  writeFileSync(path.join(folder, 'scene.yaml'), text);
  let person = null, words = '';
  try {
    const images = imagesOf(path.join(folder, 'scene.yaml'), path.join(folder, 'truth'));
    person = await Person.open({ images, rate: 30, saved, off: 2, seed: 100 * seed + i });
    const began = Date.now();
    await setUp(person, known);
    const seconds = (Date.now() - began) / 1e3;
    await until(async () => /Largest valid depth/.test(await person.stage.text('setup-largest')), 'a valid force', 20000).catch(() => {});
    await person.stage.shoot(`random-${seed}-${i}`);
    const { states } = processSaved(saved), { rms, worst, valid, sigmas, touched } = compare(states, trueStatesOf(path.join(folder, 'truth')));
    const isMet = (rms <= LIMIT || valid === 0) && seconds < MAX_S;
    met += isMet;
    if (touched) [1, ...sigmas].forEach((share, k) => { all[k] += share * touched; });
    words = `${isMet ? 'met' : 'NOT MET'}: ${seconds.toFixed(1)} s, rms ${(100 * rms).toFixed(2)} %, worst ${(100 * worst).toFixed(2)} %, valid ${(100 * valid).toFixed(0)} %, within one and two sigma ${sigmas.map((share) => `${(100 * share).toFixed(0)} %`).join(', ')}`;
  } catch (error) {
    const problems = await person?.stage.text('setup-problems').catch(() => '');
    words = `NOT MET: ${String(error.message).split('\n')[0]} ${problems}`;
    await person?.stage.shoot(`random-${seed}-${i}`).catch(() => {});
  }
  await person?.close();
  console.log(`${i} ${known.kind} ${known.width} mm, ${known.modulus} kPa, ${known.round ? 'round' : 'flat'} ${known.tool} mm: ${words}`);
}
console.log(`${met} of ${count} met; within one and two sigma ${all.slice(1).map((part) => `${((100 * part) / all[0]).toFixed(0)} %`).join(', ')} of ${all[0]} states`);
process.exit(met >= count - 1 ? 0 : 1);
