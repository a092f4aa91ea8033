// A simulated person uses the page in Chromium: browser.mjs FOLDER. Needs PALPATE_BIN and
// PALPATE_SCRATCH as tests/page/run.sh sets them. Prints {done, seconds} or {step, words}.
import { readFileSync } from 'node:fs';
import path from 'node:path';

import { Person } from '../../page/setup_person.mjs';
import { until } from '../../page/stage.mjs';

const [folder] = process.argv.slice(2), known = JSON.parse(readFileSync(path.join(folder, 'setup.json'), 'utf8'));
const person = await Person.open({ images: path.join(folder, 'frames/%06d.jpg'), rate: 30, saved: path.join(folder, 'browser'), size: [1280, 900] });
const { page, stage } = person, began = Date.now();
const settled = () => until(async () => !/\.\.\.$/.test(await stage.text('setup-hint')), 'the slave');
let result;
// Answers the questions of a step and goes to the next one. Throws the page's error message.
async function next() {
  await settled();
  const asked = page.locator('#setup-questions [data-answer=right]');
  while (await asked.count()) await asked.first().click();
  const step = () => page.locator('#setup-steps [aria-current=step]').getAttribute('data-step'), before = await step();
  await page.click('#setup-next');
  if ((await step()) === before) throw Object.assign(new Error(), { step: before, words: [await stage.text('setup-problems')] });
}
try {
  // The images repeat; the person freezes the one without contact.
  const jpeg = readFileSync(path.join(folder, known.first)).toString('base64');
  await page.route('**/setup/image*', (route) => route.fulfill({ json: { jpeg } }));
  await page.click('#setup-freeze');
  await until(async () => (await page.locator('#setup-freeze').getAttribute('data-count')) === '1', 'an image');
  await next();
  for (const place of known.scale) await person.click(place);
  await person.fill('scale.length', known.length);
  await person.fill('scale.distance', known.distance);
  await next();
  await person.choose('object.kind', known.kind);
  if (known.kind === 'rectangle') for (const key of ['width', 'height']) await person.fill(`object.${key}`, known[key]);
  if (known.kind === 'disc') await person.fill('object.diameter', known.width);
  if (known.kind === 'polygon') await person.fill('object.sides', known.sides);
  await person.fill('object.thickness', known.thickness);
  await page.selectOption('[name="object.plane"]', known.plane);
  for (const place of known.points) await person.click(place);
  if (known.kind !== 'rectangle') await page.click('#setup-pull');
  await person.shows('setup-object-fact', /clear edge/);
  await next();
  const lower = known.points.reduce(([u, v], [a, b]) => [u + a / 4, Math.max(v, b)], [0, 0]);
  for (const place of known.arcs.length ? known.arcs : [lower]) await person.click(place);
  await next();
  for (const key of ['modulus', 'poisson']) await person.fill(`material.${key}`, known[key]);
  await person.fill('material.tolerance', 0);
  await next();
  await person.fill('tool.width', known.tool);
  await person.choose('tool.shape', known.shape);
  await person.choose('tool.by', known.by);
  if (known.extent) await person.fill('tool.depth', known.extent);
  await person.drag(...known.box);
  await next();
  await settled();
  await person.confirmAll();
  await page.click('#setup-use');
  await person.shows('setup-force', /N/);
  await until(async () => /Largest valid depth/.test(await stage.text('setup-largest')), 'a valid force', 60000);
  result = { done: [await stage.text('setup-largest')], seconds: (Date.now() - began) / 1e3 };
} catch (error) {
  result = { step: error.step, words: error.words || [String(error.message).split('\n')[0], await stage.text('setup-problems').catch(() => '')] };
}
await person.close();
console.log(JSON.stringify({ asked: [], ...result }));
process.exit(0);
