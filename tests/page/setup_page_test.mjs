// The set-up in a browser, as a person does it, on images of a simulated press: first with wrong answers, then until forces come.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, readdirSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';

import { BIN, ROOT, SCRATCH, Stage, serveSetup, until } from './stage.mjs';

const SLAVE = path.join(BIN, 'palpate-slave');
// Pseudo-random numbers of a normal distribution.
const normal = (seed) => {
  const next = () => ((seed = (seed * 1664525 + 1013904223) % 4294967296) + 1) / 4294967297;
  return () => Math.sqrt(-2 * Math.log(next())) * Math.cos(2 * Math.PI * next());
};

// The images of a press and its true forces: {folder, images, states}.
function imagesOf(scene, overrides = []) {
  const folder = path.join(SCRATCH, `setup-${scene}`), images = path.join(folder, 'frames/%06d.png');
  if (!existsSync(path.join(folder, 'states.csv'))) execFileSync(SLAVE, ['process', path.join(ROOT, `deploy/scenes/${scene}.yaml`), ...overrides, '--out', folder, '--frames'], { stdio: 'ignore' });
  return { folder, images };
}
// A column of states.csv by time.
function statesOf(folder) {
  const [head, ...rows] = readFileSync(path.join(folder, 'states.csv'), 'utf8').trim().split('\n').map((line) => line.split(','));
  return rows.map((row) => Object.fromEntries(head.map((name, i) => [name, name === 'validity' || name === 'finger' || name === 'check' ? row[i] : Number(row[i])])));
}
const size = ({ fx, fy, fz }) => Math.hypot(fx, fy, fz);

// Clicks of a person: `off` px of error each.
class Person {
  constructor(stage, off, seed) {
    Object.assign(this, { stage, off, random: normal(seed) });
  }
  get page() {
    return this.stage.page;
  }
  async screen([u, v], off = this.off) {
    const [box, image] = [await this.page.locator('#setup-canvas').boundingBox(), await this.page.evaluate(() => [document.getElementById('setup-canvas').width, document.getElementById('setup-canvas').height])];
    const scale = Math.min(box.width / image[0], box.height / image[1]), error = [off * this.random(), off * this.random()];
    return [box.x + (box.width - scale * image[0]) / 2 + scale * (u + error[0] + 0.5), box.y + (box.height - scale * image[1]) / 2 + scale * (v + error[1] + 0.5)];
  }
  async click(place, off) {
    await this.page.mouse.click(...(await this.screen(place, off)));
  }
  async drag(from, to) {
    await this.page.mouse.move(...(await this.screen(from)));
    await this.page.mouse.down();
    await this.page.mouse.move(...(await this.screen(to)), { steps: 3 });
    await this.page.mouse.up();
  }
  step(name) {
    return this.page.click(`[data-step=${name}]`);
  }
  next() {
    return this.page.click('#setup-next');
  }
  fill(name, value) {
    return this.page.locator(`[name="${name}"]`).fill(value).then(() => this.page.locator(`[name="${name}"]`).blur());
  }
  shows(id, words) {
    return this.stage.shows(id, words);
  }
  undo() {
    return this.page.click('#setup-undo');
  }
}

const PIXEL = 0.35, toImage = ([x, y]) => [319.5 + (x - 44) / PIXEL, 239.5 - (y - 54) / PIXEL];
const CORNERS = [[0, 0], [88, 0], [88, 88], [0, 88]].map(toImage), TIP = toImage([44, 94.16]);

// Freezes until the tool is where the press begins: the recorded images repeat.
async function freezeAtRest(person) {
  await person.step('image');
  const [u, v] = TIP.map(Math.round);
  await until(async () => {
    const before = await person.page.evaluate(() => document.getElementById('setup-freeze').dataset.count);
    await person.page.click('#setup-freeze');
    await until(() => person.page.evaluate((old) => document.getElementById('setup-freeze').dataset.count !== old, before), 'an image');
    return person.page.evaluate(([x, y]) => {
      const canvas = document.getElementById('setup-canvas'), level = (a, b) => canvas.getContext('2d').getImageData(a, b, 1, 1).data[1];
      const isTool = (row) => Math.abs(level(x, row) - level(x - 40, row)) > 20;
      return isTool(y - 3) && !isTool(y + 4);
    }, [u, v]);
  }, 'an image at rest');
}

test("the silicone block's images, set up by clicks that are 2 px off, give the forces of the hand-written scene", async () => {
  const { folder, images } = imagesOf('silicone-block'), saved = path.join(SCRATCH, `saved-${process.pid}`);
  mkdirSync(saved, { recursive: true });
  const slave = await serveSetup(saved, images, 60), stage = await Stage.open({ scene: 'setup', slave, device: 'pointer', log: false, size: [1280, 800], scheme: 'light' });
  try {
    const person = new Person(stage, 2, 11);
    await stage.sees('#setup');
    await stage.shows('state', /OBSERVING/);
    const began = Date.now();

    // Wrong answers are told at their step, and nothing is lost.
    await person.next();
    await person.shows('setup-problems', /Freeze an image first/);
    await freezeAtRest(person);
    await person.next();
    await person.next();
    await person.shows('setup-problems', /Click two marks/);
    await person.click(toImage([0, 0]), 0);
    await person.click(toImage([0, 0]), 0);
    await person.fill('scale.length', '0');
    await person.shows('setup-problems', /0 px apart.*above 0/s);
    await person.undo();
    await person.undo();
    await person.click(toImage([88, 0]));
    await person.fill('scale.length', '88');
    await person.shows('setup-problems', '');
    await stage.shoot('setup-scale');
    await person.next();

    await person.fill('object.width', '88');
    await person.fill('object.height', '88');
    await person.fill('object.thickness', '88');
    for (const i of [0, 2, 1, 3]) await person.click(CORNERS[i]);
    await person.shows('setup-problems', /crosses itself/);
    for (let i = 0; i < 4; ++i) await person.undo();
    for (const corner of CORNERS) await person.click(corner);
    await person.shows('setup-object-fact', /9\d % of the outline|100 % of the outline/);
    await person.next();
    await person.shows('setup-problems', /thickness is measured towards the camera/);
    await person.fill('object.thickness', '9');
    await person.shows('setup-problems', '');
    await stage.shoot('setup-object');
    await person.next();

    await person.next();
    await person.shows('setup-problems', /Click the edges/);
    await person.click(toImage([44, 30]), 0);
    await person.shows('setup-problems', /No edge is there/);
    await person.click(toImage([44, 0]));
    await person.shows('setup-held-fact', /^1 of 4/);
    await person.next();

    await person.next();
    await person.shows('setup-problems', /Young's modulus: expected/);
    await person.fill('material.modulus', '127');
    await person.next();

    await person.fill('tool.width', '5.87');
    await person.drag([500, 60], [540, 130]);
    await person.shows('setup-problems', /No tool is seen in the box/);
    await person.drag([TIP[0] - 25, TIP[1] - 60], [TIP[0] + 25, TIP[1] + 10]);
    await person.shows('setup-tool-fact', /^Tip found at/);
    console.log(await stage.text('setup-tool-fact'));
    await stage.shoot('setup-tool');
    await person.next();

    await person.shows('setup-report', /force is about/);
    await stage.shoot('setup-check');
    await person.page.click('#setup-use');
    await person.shows('setup-force', /N ± /);
    console.log(`${((Date.now() - began) / 1e3).toFixed(1)} s to the first force`);
    await until(async () => /Largest valid depth so far: [2-9]/.test(await stage.text('setup-largest')), 'a valid press');
    await stage.shoot('setup-press');
    const [download] = await Promise.all([person.page.waitForEvent('download'), person.page.click('#setup-download')]);
    assert.equal(download.suggestedFilename(), 'my-object.zip');
    assert.deepEqual(stage.errors, []);
  } finally {
    await stage.close();
    await stage.endSlave();
  }
  const scenes = readdirSync(saved, { recursive: true }).filter((name) => String(name).endsWith('.yaml'));
  assert.equal(scenes.length, 1, `${readdirSync(saved)}`);
  const scene = path.join(saved, String(scenes[0])), out = path.join(saved, 'out');
  console.log(readFileSync(scene, 'utf8'));
  execFileSync(SLAVE, ['check', scene], { stdio: 'ignore' });
  execFileSync(SLAVE, ['process', scene, '--out', out], { stdio: 'ignore' });
  const hand = statesOf(folder), own = statesOf(out), peak = Math.max(...hand.map(size));
  assert.equal(own.length, hand.length);
  const off = own.map((state, i) => (state.validity === 'valid' && hand[i].validity === 'valid' ? size(state) - size(hand[i]) : 0));
  const worst = Math.max(...off.map(Math.abs)), valid = own.filter(({ validity }) => validity === 'valid').length;
  console.log(`worst ${(100 * worst / peak).toFixed(2)} % of the peak of ${peak.toFixed(3)} N, ${valid} of ${own.length} valid`);
  assert.ok(valid > 0.9 * own.length && worst < 0.03 * peak, `${worst} N of ${peak} N, ${valid} of ${own.length} valid`);
});

