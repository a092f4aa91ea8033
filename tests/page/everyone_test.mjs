// Accessibility: the set-up by keyboard alone and by touch until forces are shown; stop, replay and
// share by mouse, keyboard and touch at three widths; axe in set-up, station and replay.
import assert from 'node:assert/strict';
import { readFileSync, rmSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';

import { Person, cameraOf, imagesOf } from './setup_person.mjs';
import { ROOT, SCRATCH, Stage, size, soon, until } from './stage.mjs';

const SIZES = [[1280, 720], [1024, 640], [390, 844]];
// The camera of deploy/scenes/silicone-block.yaml.
const toImage = cameraOf({ pixel: 0.35, centre: [44, 54] });
const CORNERS = [[0, 0], [88, 0], [88, 88], [0, 88]].map(toImage), TIP = toImage([44, 94.16]);
const images = () => imagesOf(path.join(ROOT, 'deploy/scenes/silicone-block.yaml'), path.join(SCRATCH, 'setup-silicone-block'));

// Requires that no part of the page is wider than its window, and that `selector` is inside.
async function fits(page, selector) {
  const { wide, inner, box, high } = await page.evaluate((wanted) => ({ wide: document.documentElement.scrollWidth, inner: innerWidth, high: innerHeight, box: document.querySelector(wanted).getBoundingClientRect().toJSON() }), selector);
  assert.ok(wide <= inner, `the page is ${wide} px wide in a window of ${inner} px`);
  assert.ok(box.width > 0 && box.left >= 0 && box.right <= inner && box.top >= 0 && box.bottom <= high, `${selector}: ${JSON.stringify(box)} in ${inner} x ${high}`);
}
async function axe(stage, what, sizes = SIZES) {
  for (const [width, height] of sizes) {
    await stage.page.setViewportSize({ width, height });
    assert.deepEqual(await stage.violations(), [], `${what} at ${width} x ${height}`);
  }
}

test('the set-up by keyboard alone: Next is in view, the focus is visible, axe finds nothing at any step', async () => {
  const person = await Person.open({ images: images(), rate: 60, saved: path.join(SCRATCH, `saved-keys-${process.pid}`), size: [1024, 640] }), { page, stage } = person;
  const next = async (step) => {
    await axe(stage, `step ${step}`, ['object', 'tool'].includes(step) ? [SIZES[2], SIZES[0], SIZES[1]] : [SIZES[1]]);
    await fits(page, '#setup-next');
    await person.press('#setup-next');
  };
  try {
    await person.tabTo('#setup-freeze');
    await person.freezeAtRest(TIP, () => page.keyboard.press('Enter'));
    await next('image');
    for (const corner of CORNERS.slice(0, 2)) await person.setByKeys(corner);
    await person.type('scale.length', '88');
    await person.type('scale.distance', '10 m');
    await person.press('#setup-questions [data-answer=right]');
    await next('scale');
    for (const [name, text] of [['width', '88'], ['height', '8,8 cm'], ['thickness', '9']]) await person.type(`object.${name}`, text);
    // The last corner is set with an error of 30 px, selected again, and moved.
    for (const corner of [...CORNERS.slice(0, 3), [CORNERS[3][0] - 30, CORNERS[3][1]]]) await person.setByKeys(corner);
    await until(async () => !/\.\.\.$/.test(await stage.text('setup-hint')), 'the slave');
    await page.keyboard.press('PageUp');
    await person.shows('setup-place', /point 4 moves/);
    await person.setByKeys(CORNERS[3]);
    await person.shows('setup-object-fact', /9\d % of the outline|100 % of the outline/);
    const { object } = await person.answers();
    assert.ok(object.points.length === 4 && Math.abs(object.points[3][0] - CORNERS[3][0]) < 1, JSON.stringify(object.points));
    await next('object');
    await person.press('[name="held.0"]', 'Space');
    await person.shows('setup-held-fact', /^1 of 4/);
    await next('held');
    await person.type('material.modulus', '127');
    await next('material');
    await person.type('tool.width', '5.87');
    await person.press('[name="tool.by"]', 'Space');
    await person.setByKeys([TIP[0] - 24, TIP[1] - 60]);
    await person.shows('setup-place', /opposite corner/);
    await person.setByKeys([TIP[0] + 24, TIP[1] + 10]);
    await person.shows('setup-tool-fact', /^Tip found at/);
    await next('tool');
    await person.shows('setup-contact', /force is about/);
    await axe(stage, 'step check');
    await stage.shoot('everyone-check-390');
    await page.setViewportSize({ width: 1024, height: 640 });
    await person.press('#setup-right');
    await person.press('#setup-use');
    await person.shows('setup-force', /^[\d.]+ N/);
    await axe(stage, 'step press');
    assert.deepEqual(stage.errors, []);
  } finally {
    await person.close();
  }
});

test('the set-up by touch in 390 px: pinch, taps, drags of a point and of the box', async () => {
  const person = await Person.open({ images: images(), rate: 60, saved: path.join(SCRATCH, `saved-touch-${process.pid}`), size: [390, 844], touch: true }), { page, stage } = person;
  const session = await page.context().newCDPSession(page);
  const touch = (type, ...points) => session.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  const canvas = page.locator('#setup-canvas');
  const at = async (place) => {
    await canvas.scrollIntoViewIfNeeded();
    return person.screen(place, 0);
  };
  const tap = async (place) => page.touchscreen.tap(...(await at(place)));
  const swipe = async (from, to) => {
    const [a, b] = [await at(from), await at(to)];
    await touch('touchStart', a);
    for (const part of [0.3, 0.7, 1]) await touch('touchMove', a.map((value, k) => value + part * (b[k] - value)));
    await touch('touchEnd');
  };
  const next = () => page.locator('#setup-next').tap();
  try {
    await fits(page, '#setup-next');
    assert.ok((await canvas.boundingBox()).width > 300);
    await person.freezeAtRest(TIP, () => page.locator('#setup-freeze').tap());
    await next();
    const zoom = () => canvas.evaluate((element) => element.getBoundingClientRect().width / element.parentElement.getBoundingClientRect().width);
    const [x, y] = await at([319, 239]);
    await touch('touchStart', [x - 20, y], [x + 20, y]);
    for (const apart of [40, 60, 80]) await touch('touchMove', [x - apart, y], [x + apart, y]);
    await touch('touchEnd');
    assert.ok((await zoom()) > 2, `${await zoom()}`);
    assert.equal((await person.answers()).scale.points.length, 0);
    await page.locator('#setup-fit').tap();
    assert.ok(Math.abs((await zoom()) - 1) < 0.01);
    await tap(CORNERS[0]);
    await tap(CORNERS[1]);
    await person.fillScale('88');
    await next();
    for (const [key, value] of [['width', 88], ['height', 88], ['thickness', 9]]) await person.fill(`object.${key}`, value);
    for (const corner of [...CORNERS.slice(0, 3), [CORNERS[3][0] + 45, CORNERS[3][1] + 60]]) await tap(corner);
    await until(async () => !/\.\.\.$/.test(await stage.text('setup-hint')), 'the slave');
    await swipe([CORNERS[3][0] + 45, CORNERS[3][1] + 60], CORNERS[3]);
    await person.shows('setup-object-fact', /9\d % of the outline|100 % of the outline/);
    // A fifth tap changes nothing.
    const { object } = await person.answers();
    await tap([319, 260]);
    await person.shows('setup-problems', /All four corners are set/);
    assert.deepEqual((await person.answers()).object.points, object.points);
    await next();
    await tap(toImage([44, 0]));
    await person.shows('setup-held-fact', /^1 of 4/);
    await next();
    await person.fill('material.modulus', '127');
    await next();
    await person.fill('tool.width', '5.87');
    await page.locator('[name="tool.by"][value=whole]').tap();
    await swipe([TIP[0] - 26, TIP[1] - 60], [TIP[0] + 26, TIP[1] + 10]);
    await person.shows('setup-tool-fact', /^Tip found at/);
    await stage.shoot('everyone-tool-390');
    await next();
    await person.confirmAll();
    await page.locator('#setup-use').tap();
    await person.shows('setup-force', /^[\d.]+ N/);
    await stage.shoot('everyone-press-390');
    assert.deepEqual(stage.errors, []);
  } finally {
    await person.close();
  }
});

// Presses `selector` of the page of `stage`, within `timeout` [ms].
const WAYS = {
  mouse: (stage, selector, timeout) => stage.page.locator(selector).click({ timeout }),
  keyboard: (stage, selector) => new Person(stage).press(selector),
  touch: (stage, selector, timeout) => stage.page.locator(selector).tap({ timeout }),
};
// Calls `act(press, what)` for each kind of input at each width; with PALPATE_QUICK for one kind at
// each width.
async function everyWay(stage, act) {
  const ways = Object.entries(WAYS);
  for (const [index, [width, height]] of SIZES.entries()) {
    await stage.page.setViewportSize({ width, height });
    for (const [way, press] of process.env.PALPATE_QUICK ? [ways[index]] : ways) await act((selector, timeout) => press(stage, selector, timeout), `${way} at ${width} px`);
  }
}
async function shares(stage, press, what) {
  const [download] = await Promise.all([stage.page.waitForEvent('download'), press('#share')]);
  const text = readFileSync(await download.path(), 'utf8');
  assert.ok(text.includes('id="clip"'), what);
}

test('stop, share and replay by mouse, by keyboard alone and by touch, at three widths', async () => {
  const file = path.join(SCRATCH, 'ways.mcap');
  rmSync(file, { force: true });
  const live = await Stage.open({ scene: 'silicone-block', args: ['--record', file], scheme: 'light', touch: true });
  try {
    await live.when(({ slave_state: state }) => state, 'a state');
    await live.shows('unconnected', 'Not connected to haptic device: a simulated operator leads; a real object: sensors and manipulator are simulated.');
    await everyWay(live, async (press, what) => {
      await fits(live.page, '#stop');
      await press('#stop');
      await live.when(({ state }) => state === 'ESTOP', `the stop by ${what}`);
      // On a busy machine the page may hide the button for a moment; then a person presses again.
      const isReset = () => live.status.state !== 'ESTOP';
      await until(async () => isReset() || (await press('#reset', 2000).catch(() => {}), soon(isReset)), `the end of the stop by ${what}`);
      await shares(live, press, what);
    });
    assert.deepEqual(live.errors, []);
  } finally {
    await live.close();
  }
  const replay = await Stage.replay(file, [], true);
  try {
    await until(() => replay.status?.replay, 'the replay');
    await replay.shows('unconnected', 'Not connected to anything: this is a recording.');
    await everyWay(replay, async (press, what) => {
      const { playing } = replay.status.replay;
      await fits(replay.page, '#play');
      await press('#play');
      await replay.when((status) => status.replay.playing !== playing, `play or pause by ${what}`);
      await shares(replay, press, what);
    });
    assert.deepEqual(replay.errors, []);
  } finally {
    await replay.close();
  }
});

test('axe finds nothing in station and replay, and no part is wider than the window', async () => {
  const file = path.join(SCRATCH, 'everyone.mcap');
  rmSync(file, { force: true });
  const live = await Stage.open({ scene: 'silicone-block', args: ['--record', file], scheme: 'light' });
  const views = async (stage, name) => {
    for (const theme of ['light', 'dark']) {
      await stage.page.evaluate((wanted) => document.documentElement.dataset.theme !== wanted && document.getElementById('theme').click(), theme);
      await axe(stage, `${name}, ${theme}`);
      for (const [width, height] of SIZES) {
        await stage.page.setViewportSize({ width, height });
        const [wide, inner] = await stage.page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
        assert.ok(wide <= inner, `${name} is ${wide} px wide in ${inner}`);
        await stage.shoot(`everyone-${name}-${theme}-${width}`);
      }
    }
  };
  try {
    await live.when(({ slave_state: state }) => state?.force && size(['x', 'y', 'z'].map((axis) => state.force[axis])) > 0.3, 'a press');
    await views(live, 'station');
    assert.deepEqual(live.errors, []);
  } finally {
    await live.close();
  }
  const replay = await Stage.replay(file);
  try {
    await replay.shows('badge', 'REPLAY');
    await until(() => replay.status?.replay, 'the replay');
    await views(replay, 'replay');
    assert.deepEqual(replay.errors, []);
  } finally {
    await replay.close();
  }
});
