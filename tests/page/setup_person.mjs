// A simulated person who sets up a slave in the browser, with clicks that have errors of some
// pixels.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync } from 'node:fs';
import path from 'node:path';

import { BIN, Stage, serveSetup, until } from './stage.mjs';

export const SLAVE = path.join(BIN, 'palpate-slave');
// Pseudo-random numbers: uniform from 0 to 1, and of a normal distribution.
export const uniform = (seed) => () => ((seed = (seed * 1664525 + 1013904223) % 4294967296) + 0.5) / 4294967296;
const normal = (seed) => {
  const next = uniform(seed);
  return () => Math.sqrt(-2 * Math.log(next())) * Math.cos(2 * Math.PI * next());
};

// Simulates the press of a scene file. Writes its images, and the forces of the scene in
// states.csv.
export function imagesOf(scene, folder, overrides = []) {
  if (!existsSync(path.join(folder, 'states.csv'))) execFileSync(SLAVE, ['process', scene, '--out', folder, '--frames', ...overrides], { stdio: 'ignore' });
  return path.join(folder, 'frames/%06d.png');
}
export function statesOf(folder) {
  const [head, ...rows] = readFileSync(path.join(folder, 'states.csv'), 'utf8').trim().split('\n').map((line) => line.split(','));
  return rows.map((row) => Object.fromEntries(head.map((name, i) => [name, ['validity', 'finger', 'check'].includes(name) ? row[i] : Number(row[i])])));
}
// Returns the true forces of a simulated run.
export const trueStatesOf = (folder) => statesOf(folder).map((state) => ({ ...state, fx: state.true_fx, fy: state.true_fy, fz: state.true_fz, validity: 'valid' }));
const size = ({ fx, fy, fz }) => Math.hypot(fx, fy, fz);
// Compares the forces of two folders with the same images. Errors are relative to the largest
// force: {worst, rms, valid: share, sigmas: shares within one and two sigma, touched: number of
// states in contact}.
export function compare(own, wanted) {
  const peak = Math.max(...wanted.map(size)), pairs = own.map((state, i) => [state, wanted[i]]).filter(([a, b]) => a.validity === 'valid' && b?.validity === 'valid');
  const off = pairs.map(([a, b]) => (size(a) - size(b)) / peak), touched = pairs.filter(([, b]) => size(b) > 0.02 * peak);
  const within = (count) => touched.filter(([a, b]) => Math.abs(size(a) - size(b)) <= count * a.sigma).length / touched.length;
  return { peak, worst: Math.max(...off.map(Math.abs)), rms: Math.sqrt(off.reduce((sum, value) => sum + value * value, 0) / off.length), valid: pairs.length / own.length, sigmas: [within(1), within(2)], touched: touched.length };
}

// Returns a function that maps a point of S [mm] to the image [px], for a scene's camera of `width`
// x `height` px.
export const cameraOf = ({ width = 640, height = 480, pixel, centre }) => ([x, y]) => [(width - 1) / 2 + (x - centre[0]) / pixel, (height - 1) / 2 - (y - centre[1]) / pixel];

export class Person {
  constructor(stage, { off = 0, seed = 1 } = {}) {
    Object.assign(this, { stage, off, random: normal(seed) });
  }
  // Starts a slave that waits for a scene with `images`, its station, and a person at it.
  static async open({ images, rate, saved, off, seed, slaveArgs, ...station }) {
    mkdirSync(saved, { recursive: true });
    const slave = await serveSetup(saved, images, rate, slaveArgs), stage = await Stage.open({ scene: 'setup', slave, device: 'pointer', log: false, size: [1280, 800], scheme: 'light', ...station });
    await stage.sees('#setup');
    return new Person(stage, { off, seed });
  }
  async close() {
    await this.stage.close();
    await this.stage.endSlave();
  }
  get page() {
    return this.stage.page;
  }
  async screen([u, v], off = this.off) {
    const box = await this.page.locator('#setup-canvas').boundingBox(), image = await this.page.evaluate(() => [document.getElementById('setup-canvas').width, document.getElementById('setup-canvas').height]);
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
  next() {
    return this.page.click('#setup-next');
  }
  undo() {
    return this.page.click('#setup-undo');
  }
  async fill(name, value) {
    await this.page.locator(`[name="${name}"]`).fill(String(value));
    await this.page.locator(`[name="${name}"]`).blur();
  }
  // Enters the length between the two marks. The rays of the simulated camera are parallel, as for
  // a distant lens.
  async fillScale(length) {
    await this.fill('scale.length', length);
    await this.fill('scale.distance', '10 m');
    await this.page.click('#setup-questions [data-answer=right]');
  }
  choose(name, value) {
    return this.page.check(`[name="${name}"][value="${value}"]`);
  }
  // Answers all questions, including those of step `check`, with "right".
  async confirmAll() {
    await until(async () => {
      const asked = this.page.locator('#setup-questions [data-answer=right]');
      if (await asked.count()) await asked.first().click();
      return (await this.page.isVisible('#setup-right')) || this.page.isEnabled('#setup-use');
    }, 'the sentences of the check');
    if (await this.page.isVisible('#setup-right')) await this.page.click('#setup-right');
    await until(() => this.page.isEnabled('#setup-use'), 'that the scene may be used');
  }
  shows(id, words) {
    return this.stage.shows(id, words);
  }
  go(step) {
    return this.page.click(`#setup-steps [data-step=${step}]`);
  }
  // Returns the answers that the page stores for a reload, without the image.
  async answers() {
    return (await this.page.evaluate(() => JSON.parse(sessionStorage.getItem('setup')))).now;
  }
  // Freezes images until the tool's end is at `tip` [px], where the press begins, because the
  // recorded images repeat.
  async freezeAtRest(tip, freeze = () => this.page.click('#setup-freeze')) {
    const [u, v] = tip.map(Math.round);
    await until(async () => {
      const before = await this.page.locator('#setup-freeze').getAttribute('data-count');
      await freeze();
      await until(async () => (await this.page.locator('#setup-freeze').getAttribute('data-count')) !== before, 'an image');
      return this.page.evaluate(([x, y]) => {
        const pen = document.getElementById('setup-canvas').getContext('2d'), level = (a, b) => pen.getImageData(a, b, 1, 1).data[1];
        const isTool = (row) => Math.abs(level(x, row) - level(x - 60, row)) > 20;
        return isTool(y - 3) && !isTool(y + 4);
      }, [u, v]);
    }, 'an image at rest');
  }
  // Presses Tab until the focused element matches `selector`. The focus must be visible.
  async tabTo(selector) {
    const focused = () => this.page.evaluate((wanted) => {
      const { activeElement: at } = document;
      return at?.matches(wanted) ? getComputedStyle(at).outlineStyle : null;
    }, selector);
    for (let i = 0; i < 120; ++i) {
      const outline = await focused();
      if (outline === 'none') throw new Error(`the focus on ${selector} is not visible`);
      if (outline) return;
      await this.page.keyboard.press('Tab');
    }
    throw new Error(`Tab does not lead to ${selector}`);
  }
  async press(selector, key = 'Enter') {
    await this.tabTo(selector);
    await this.page.keyboard.press(key);
  }
  async type(name, text) {
    await this.tabTo(`[name="${name}"]`);
    await this.page.keyboard.type(text);
    await this.page.keyboard.press('Tab');
  }
  // Moves the cross to `place` by arrow keys, and presses Enter.
  async setByKeys(place) {
    await this.tabTo('#setup-canvas');
    const cross = async () => {
      const [, u, v] = (await this.stage.text('setup-place')).match(/^Cross at (\d+), (\d+) px/) || [];
      return u && [Number(u), Number(v)];
    };
    await this.page.keyboard.press('ArrowRight');
    let now = await until(cross, 'the place of the cross');
    for (const [k, [less, more]] of [['ArrowLeft', 'ArrowRight'], ['ArrowUp', 'ArrowDown']].entries()) {
      while (Math.round(place[k]) !== now[k]) {
        const off = Math.round(place[k]) - now[k], step = Math.abs(off) >= 10 ? 10 : 1;
        await this.page.keyboard.press(`${step === 1 ? 'Shift+' : ''}${off > 0 ? more : less}`);
        now = now.map((value, i) => (i === k ? value + Math.sign(off) * step : value));
      }
    }
    assert.deepEqual(await until(async () => (await cross())?.join() === now.join() && now, `the cross at ${now}`), now);
    await this.page.keyboard.press('Enter');
  }
  // Draws the box around the tip of a tool of `width` px that points down.
  boxTip([u, v], width) {
    return this.drag([u - width / 2 - 15, v - 60], [u + width / 2 + 15, v + 10]);
  }
}

// Processes the images of the scene in `saved`: {scene, states}.
export function processSaved(saved) {
  const scene = path.join(saved, 'scene.yaml'), out = path.join(saved, 'out');
  execFileSync(SLAVE, ['check', scene], { stdio: 'ignore' });
  execFileSync(SLAVE, ['process', scene, '--out', out], { stdio: 'ignore' });
  return { scene, states: statesOf(out) };
}
