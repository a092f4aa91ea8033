// Tests zooming and reading of the charts, and the shared file: it opens without a network and
// shows the received forces.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, rmSync, statSync } from 'node:fs';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';

import { BIN, PATIENCE_MS, SCRATCH, Stage, size, until, violationsOf } from './stage.mjs';

const PYTHON = path.resolve(BIN, '../python');

describe('a press in charts and in a shared file', () => {
  let stage, shared;
  const recording = path.join(SCRATCH, 'share.mcap'), file = path.join(SCRATCH, 'share.html');
  before(async () => {
    rmSync(recording, { force: true });
    stage = await Stage.open({ scene: 'silicone-block', args: ['--record', recording], scheme: 'light' });
  });
  after(() => stage.close());

  test('the charts have units, show the values of one time, and zoom together', async () => {
    const { page } = stage;
    await stage.when(({ slave_state: state }) => state?.force && size(['x', 'y', 'z'].map((axis) => state.force[axis])) > 0.3, 'a press');
    await until(async () => (await page.locator('#strips .u-over').count()) === 6, 'six strips');
    assert.match(await page.locator('#strips').innerText(), /Force, N[^]*Tip path, mm[^]*Link, ms/);
    await until(async () => /^[\d.]+ g$/.test(await stage.text('grams')), 'grams');
    const plot = page.locator('.strip .u-over').first(), box = await plot.boundingBox(), at = (part) => [box.x + part * box.width, box.y + box.height / 2];
    // Waits for samples before the last second.
    await until(async () => {
      await page.mouse.move(...at(0.97));
      await page.mouse.move(...at(0.98));
      return /^-\d+\.\d\d s: [\d.e-]+ N, [\d.e-]+ g$/.test(await stage.text('charts-time'));
    }, 'the force at the cursor');
    // The legend of another strip shows the values of the same time.
    await until(async () => /age [\d.]+/.test(await page.locator('.strip .legend').nth(2).innerText()), 'the values of another strip');
    const [newtons, grams] = (await stage.text('charts-time')).match(/: (\S+) N, (\S+) g/).slice(1).map(Number);
    assert.ok(Math.abs(grams * 9.80665e-3 - newtons) <= 0.006 * newtons + 1e-6, `${newtons} N, ${grams} g`);
    await page.mouse.move(...at(0.7));
    await page.mouse.down();
    await page.mouse.move(...at(0.9), { steps: 4 });
    await page.mouse.up();
    await stage.shows('charts-aside', 'paused');
    await stage.sees('#charts-whole');
    await stage.shoot('share-zoom');
    await page.locator('#view').focus();
    await page.keyboard.press('0');
    await stage.sees('#charts-whole', false);
    await stage.shows('charts-aside', '');
    await page.keyboard.press('+');
    await stage.shows('charts-aside', 'paused');
    // While the charts pause, image and object show the time of the cursor, which the arrow keys move, too.
    const cursor = async () => Number((await stage.text('image-age')).match(/^paused at (-?[\d.]+) s$/)?.[1]);
    await page.locator('#strips').focus();
    await page.keyboard.press('ArrowLeft');
    const first = await until(async () => (await cursor()) <= 0 && cursor(), 'a time of the cursor');
    await page.keyboard.press('Shift+ArrowLeft');
    await until(async () => (await cursor()) < first, 'an earlier time');
    assert.equal(await stage.text('model-age'), await stage.text('image-age'));
    await page.locator('#charts-whole').click();
    await stage.shows('charts-aside', '');
    await stage.shows('image-age', /^\d+ ms old$/);
  });

  test('one button writes one file of at most 8 MB a minute', async () => {
    await until(() => stage.statuses.some(({ slave_state: state }) => state?.local_model?.in_contact) && stage.statuses.length > 150, 'some seconds with a contact');
    const [download] = await Promise.all([stage.page.waitForEvent('download', { timeout: PATIENCE_MS }), stage.page.click('#share')]);
    await download.saveAs(file);
    assert.equal(download.suggestedFilename(), 'palpate-silicone-block.html');
    shared = JSON.parse(readFileSync(file, 'utf8').match(/<script type="application\/json" id="clip">([^]*?)<\/script>/)[1]);
    const { states, images, field, words } = shared, seconds = Math.max(1, states.at(-1).t);
    console.log(`${statSync(file).size} bytes for ${seconds.toFixed(1)} s: ${states.length} states, ${images.length} images, ${field.frames.length} fields`);
    assert.ok(statSync(file).size <= (8e6 / 60) * seconds, 'its size');
    assert.ok(states.length > 20 && images.length > 3 && field.frames.length > 3, 'what it holds');
    assert.ok(words.some((text) => /rectangle/.test(text)), words.join());
    assert.ok(field.full > 1e-4 && field.full < 1e-2, `${field.full} m`);
    assert.deepEqual(stage.errors, []);
  });

  test('without a network it shows the forces that palpate.export finds in the recording', async () => {
    const browser = stage.context.browser(), context = await browser.newContext({ offline: true }), page = await context.newPage(), errors = [], requests = [];
    page.on('pageerror', (error) => errors.push(String(error)));
    page.on('request', (request) => /^(file|data):/.test(request.url()) || requests.push(request.url()));
    await stage.endMaster();
    const forces = forcesOf(recording), { states } = shared;
    let compared = 0;
    for (const { sequence, force, sigma } of states) {
      const known = forces.get(sequence);
      if (!known || force === null) continue;
      compared += 1;
      assert.ok(Math.abs(known.force - force) < 1e-9 + 1e-6 * force && Math.abs(known.sigma - sigma) < 1e-9 + 1e-6 * sigma, `${sequence}: ${force} N, exported ${known.force} N`);
    }
    assert.ok(compared > 0.5 * states.length, `${compared} of ${states.length} states are in the recording`);
    await page.goto(`file://${file}`);
    const most = states.reduce((best, state) => (state.force > best.force ? state : best));
    const goTo = (t) => page.locator('#place').fill(String(Math.min(Math.ceil(100 * t) / 100, Math.floor(100 * states.at(-1).t) / 100)));
    await goTo(most.t);
    const shown = Number((await page.locator('#force').innerText()).match(/: ([\d.]+) N/)[1]);
    assert.ok(states.some(({ t, force }) => Math.abs(t - most.t) < 0.2 && Math.abs(force - shown) < 6e-4), `${shown} N for ${most.force} N`);
    // Fields are rarer than states: the one before the largest force may be of an earlier, shallower press.
    const sizeOf = ({ values }) => Buffer.from(values, 'base64').reduce((sum, value) => sum + value, 0);
    await goTo(shared.field.frames.reduce((best, frame) => (sizeOf(frame) > sizeOf(best) ? frame : best)).t);
    // The image is grey, so coloured pixels are the field or an overlay of the slave, which
    // contains no blue-green.
    const greens = () => page.locator('#view').evaluate((view) => {
      const { data } = view.getContext('2d').getImageData(0, 0, view.width, view.height);
      let count = 0;
      for (let i = 0; i < data.length; i += 4) count += data[i + 1] > data[i] + 25 && data[i + 2] > data[i] + 25;
      return count;
    });
    assert.ok(await until(async () => (await greens()) > 500 && greens(), 'the field in colours'));
    for (const width of [1280, 390]) {
      await page.setViewportSize({ width, height: 844 });
      assert.deepEqual(await violationsOf(page), [], `${width} px`);
    }
    await page.locator('#place').fill('0');
    await page.locator('#play').click();
    await until(() => page.locator('#place').evaluate((place) => place.valueAsNumber > 0.3), 'that it plays');
    await page.screenshot({ path: path.join(SCRATCH, 'share-file.png'), fullPage: true });
    assert.deepEqual([errors, requests], [[], []]);
    await context.close();
  });
});

// Reads force and sigma by sequence from the master's recording, as palpate.export does.
const READ = `import pathlib, sys
from palpate.export import _columns
from palpate.recording import messages, parsed
from palpate.v1 import state_pb2
for topic, _, data in messages(pathlib.Path(sys.argv[1])):
    if topic == "/slave/state":
        row = _columns(parsed(state_pb2.SlaveState, data, sys.argv[1]))
        print(row["sequence"], *row["force"], row["sigma"])
`;
function forcesOf(recording) {
  const env = { ...process.env, PYTHONPATH: PYTHON, OMP_NUM_THREADS: '1', PYTHONDONTWRITEBYTECODE: '1' };
  const rows = execFileSync('/usr/bin/python3', ['-c', READ, recording], { env, encoding: 'utf8', maxBuffer: 1e8 }).trim().split('\n').map((line) => line.split(' '));
  return new Map(rows.map(([sequence, x, y, z, sigma]) => [sequence, { force: size([x, y, z].map(Number)), sigma: Number(sigma) }]));
}
