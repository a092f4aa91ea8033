// A person sets up a slave in a browser with images of a simulated press: first with wrong answers,
// then until forces are shown.
import assert from 'node:assert/strict';
import { mkdirSync, readFileSync, rmSync, symlinkSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { isDeepStrictEqual } from 'node:util';

import { Person, cameraOf, compare, imagesOf, processSaved, statesOf } from './setup_person.mjs';
import { ROOT, SCRATCH, certificate, until } from './stage.mjs';

// These tests are skipped with PALPATE_QUICK.
const deepTest = process.env.PALPATE_QUICK ? () => {} : test;
// The camera of deploy/scenes/silicone-block.yaml.
const toImage = cameraOf({ pixel: 0.35, centre: [44, 54] });
const CORNERS = [[0, 0], [88, 0], [88, 88], [0, 88]].map(toImage), TIP = toImage([44, 94.16]);

test("the silicone block's images, set up by clicks that are 2 px off, give the forces of the hand-written scene", async () => {
  const folder = path.join(SCRATCH, 'setup-silicone-block'), saved = path.join(SCRATCH, `saved-${process.pid}`);
  const images = imagesOf(path.join(ROOT, 'deploy/scenes/silicone-block.yaml'), folder);
  const person = await Person.open({ images, rate: 60, saved, off: 2, seed: 11 }), { stage } = person;
  try {
    await stage.shows('state', /OBSERVING/);
    const began = Date.now();

    // Wrong answers are reported at their step, and nothing is lost.
    await person.next();
    await person.shows('setup-problems', /Freeze an image first/);
    await person.freezeAtRest(TIP);
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
    await person.fillScale('88');
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
    await person.shows('setup-problems', /You chose "thin", but the thickness/);
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

    await person.fill('tool.width', '5,87');
    await person.choose('tool.by', 'whole');
    await person.drag([500, 60], [540, 130]);
    await person.shows('setup-problems', /No tool is seen in the box/);
    await person.boxTip(TIP, 5.87 / 0.35);
    await person.shows('setup-tool-fact', /^Tip found at/);
    console.log(await stage.text('setup-tool-fact'));
    await stage.shoot('setup-tool');
    await person.next();

    await person.shows('setup-sentences', /88 mm wide and 88 mm high, .*9 mm thick.*as stiff as silicone of Shore 00-50.*1 mm deep .* weight of \d+ g.*flat end, 5\.87 mm wide.*Held: the lower edge/s);
    assert.ok(!(await person.page.isEnabled('#setup-use')), 'used before it was confirmed');
    await stage.shoot('setup-check');
    await person.page.click('#setup-wrong');
    await person.page.locator('#setup-sentences [data-answer=wrong]').nth(1).click();
    assert.equal(await person.page.locator('#setup-steps [aria-current=step]').getAttribute('data-step'), 'material');
    await person.go('check');
    await person.confirmAll();
    await person.fill('name.text', 'rubber-block');
    // The slave's new scene is known before its answer.
    await person.page.route('**/setup/use*', async (route) => {
      const response = await route.fetch();
      await person.page.waitForTimeout(1500);
      await route.fulfill({ response });
    }, { times: 1 });
    await person.page.click('#setup-use');
    await person.shows('setup-force', /N ± .* g\) at /);
    console.log(`${((Date.now() - began) / 1e3).toFixed(1)} s to the first force`);
    await until(async () => /Largest valid depth so far: [2-9]/.test(await stage.text('setup-largest')), 'a valid press');
    await stage.shoot('setup-press');
    const [download] = await Promise.all([person.page.waitForEvent('download'), person.page.click('#setup-download')]);
    assert.equal(download.suggestedFilename(), 'rubber-block.zip');
    await person.page.click('#setup-close');
    await stage.shows('scene', 'rubber-block');
    await until(async () => Number(await stage.text('magnitude')) > 1, 'the force in the station');
    await stage.shoot('setup-station');
    assert.deepEqual(stage.errors, []);
  } finally {
    await person.close();
  }
  const { scene, states } = processSaved(saved), hand = statesOf(folder);
  assert.equal(states.length, hand.length);
  const { worst, valid, peak } = compare(states, hand);
  console.log(readFileSync(scene, 'utf8'));
  console.log(`worst ${(100 * worst).toFixed(2)} % of the peak of ${peak.toFixed(3)} N, ${(100 * valid).toFixed(0)} % valid`);
  assert.ok(valid > 0.9 && worst < 0.03, `${worst}, ${valid} valid`);
});

const BLOCK = path.join(ROOT, 'deploy/scenes/silicone-block.yaml');

// Answers all steps except the last two.
async function answerAll(person, { modulus = '127', identify = false } = {}) {
  await person.freezeAtRest(TIP);
  await person.go('scale');
  for (const place of [[0, 0], [88, 0]]) await person.click(toImage(place));
  await person.fillScale('88');
  await person.go('object');
  for (const [key, value] of [['width', 88], ['height', 88], ['thickness', 9]]) await person.fill(`object.${key}`, value);
  for (const corner of CORNERS) await person.click(corner);
  await person.shows('setup-object-fact', /9\d % of the outline|100 % of the outline/);
  await person.go('held');
  await person.click(toImage([44, 0]));
  await person.go('material');
  if (identify) await person.choose('material.by', 'identify');
  await person.fill('material.modulus', modulus);
  await person.go('tool');
  await person.fill('tool.width', '5.87');
  await person.choose('tool.by', 'whole');
  await person.boxTip(TIP, 5.87 / 0.35);
  await person.shows('setup-tool-fact', /^Tip found at/);
}

// The next image that the page freezes is drawn with `filter`, and with `paper` and `boxes` [u, v, width, height] on it.
const alterNextImage = (page, { filter = 'none', paper = [0, 0, 0, 0], boxes = [] }) => page.route('**/setup/image', async (route) => {
  const reply = await (await route.fetch()).json();
  const jpeg = await page.evaluate(async ([base64, look, sheet, black]) => {
    const image = await createImageBitmap(new Blob([Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0))]));
    const canvas = Object.assign(document.createElement('canvas'), { width: image.width, height: image.height }), pen = canvas.getContext('2d');
    pen.filter = look;
    pen.drawImage(image, 0, 0);
    pen.fillStyle = '#ddd';
    pen.fillRect(...sheet);
    pen.fillStyle = '#222';
    for (const box of black) pen.fillRect(...box);
    return canvas.toDataURL('image/jpeg', 1).split(',')[1];
  }, [reply.jpeg, filter, paper, boxes]);
  await route.fulfill({ json: { jpeg } });
}, { times: 1 });

deepTest('each of 27 wrong answers gives a message at its step, changes no other step, and is undone', async () => {
  const images = imagesOf(BLOCK, path.join(SCRATCH, 'setup-silicone-block'));
  const person = await Person.open({ images, rate: 60, saved: path.join(SCRATCH, `saved-wrong-${process.pid}`) }), { page, stage } = person;
  const fill = (name, value) => () => person.fill(name, value);
  const clicks = (...places) => async () => { for (const place of places) await person.click(place, 0); };
  const erase = () => page.click('#setup-erase');
  const all = (...acts) => async () => { for (const act of acts) await act(); };
  const board = (columns, rows, square) => all(() => person.choose('scale.by', 'board'), fill('scale.columns', columns), fill('scale.rows', rows), fill('scale.square', square), () => page.click('#setup-board'));
  const box = (from, to) => () => person.drag(from, to), [u, v] = TIP;
  const byMaterial = (name) => () => person.choose('material.by', name);
  const darken = async () => { await alterNextImage(page, { filter: 'brightness(0.1)' }); await page.click('#setup-freeze'); };
  const cases = [
    ['image', darken, /too dark/],
    ['image', () => page.click('#setup-live'), /Freeze an image first/],
    ['scale', all(erase, clicks(CORNERS[0])), /Click two marks/],
    ['scale', all(erase, clicks(CORNERS[0], CORNERS[0])), /0 px apart/],
    ['scale', clicks(CORNERS[3]), /Both marks are set/],
    ['scale', fill('scale.length', '1,234'), /could be 1\.234 or 1234/],
    ['scale', fill('scale.length', '0'), /above 0/],
    ['scale', fill('scale.length', '8800000'), /Give the length in mm/],
    ['scale', board('9', '6', ''), /Edge of a square: expected/],
    ['scale', board('2', '6', '8'), /Inner corners of the board/],
    ['scale', board('9', '6', '8'), /The board is not seen/],
    ['object', all(erase, clicks(...CORNERS.slice(0, 3))), /3 so far/],
    ['object', clicks(CORNERS[1]), /All four corners are set/],
    ['object', all(erase, clicks(...[0, 2, 1, 3].map((i) => CORNERS[i]))), /crosses itself/],
    ['object', all(erase, clicks(...[[40, 30], [120, 30], [120, 100], [40, 100]])), /No clear edge/],
    ['object', fill('object.width', '60'), /The width is 60 mm/],
    ['object', fill('object.thickness', '88'), /You chose "thin", but the thickness/],
    ['held', clicks(toImage([44, 0])), /Click the edges/],
    ['held', clicks(toImage([44, 40])), /No edge is there/],
    ['held', clicks(...[[88, 44], [44, 88], [0, 44]].map(toImage)), /All edges are held/],
    ['material', fill('material.modulus', 'soft'), /Young's modulus: "soft": expected/],
    ['material', fill('material.poisson', '0.6'), /Poisson's ratio/],
    ['material', byMaterial('name'), /Choose a material/],
    ['tool', fill('tool.width', '9'), /the image shows 5\.\d|No tool is seen/],
    ['tool', box([500, 60], [540, 130]), /No tool is seen in the box/],
    // Not from a corner of the box that is shown: that would move it.
    ['tool', box([u + 25, v - 60], [u - 25, v - 15]), /end of the tool hardly differs/, 'setup-questions'],
    ['tool', box([u - 4, v - 6], [u + 4, v + 2]), /too small/],
  ];
  try {
    await answerAll(person);
    const wanted = await person.answers();
    for (const [step, act, words, where = 'setup-problems'] of cases) {
      await person.go(step);
      await act();
      await until(async () => !/\.\.\.$/.test(await stage.text('setup-hint')), 'the slave');
      if (!words.test(await stage.text(where))) await person.next();
      await person.shows(where, words);
      console.log(step, await stage.text(where));
      assert.equal(await page.locator('#setup-steps [aria-current=step]').getAttribute('data-step'), step, `${words}`);
      const now = await person.answers(), others = (answers) => ({ ...answers, tool: { ...answers.tool, seen: null }, [step]: null });
      assert.deepEqual(others(now), others(wanted), `${words}`);
      for (let i = 0; i < 9 && !isDeepStrictEqual(await person.answers(), wanted) && (await page.isEnabled('#setup-undo')); ++i) await person.undo();
      assert.deepEqual(await person.answers(), wanted, `${words}`);
    }
    console.log(`${cases.length} wrong answers`);
    // A reload keeps answers and step.
    await person.go('held');
    await page.reload();
    await person.shows('setup-held-fact', /^1 of 4/);
    assert.deepEqual(await person.answers(), wanted);
    await person.go('check');
    await person.shows('setup-contact', /force is about/);
    assert.deepEqual(stage.errors.filter((text) => !/status of (400|409)/.test(text)), []);
  } finally {
    await person.close();
  }
});

// Makes images of `steps` of a slow press, each some seconds long. The tool moves back and forth
// over three images, so that consecutive images differ.
function stepsOf(folder, steps) {
  const states = statesOf(folder), held = path.join(SCRATCH, 'setup-steps'), swing = [0, 1, 2, 3, 2, 1], places = [];
  rmSync(held, { recursive: true, force: true });
  mkdirSync(held, { recursive: true });
  let count = 0;
  const show = (i) => symlinkSync(path.join(folder, `frames/${String(i + 1).padStart(6, '0')}.png`), path.join(held, `${String(++count).padStart(6, '0')}.png`));
  const top = states[0].tip_y, at = (depth) => states.findIndex(({ tip_y }) => tip_y < 0.088 - depth);
  for (let i = 0; i < 40; ++i) show(i);
  let last = 40;
  for (const depth of steps) {
    const first = at(depth);
    for (; last < first; last += 6) show(last);
    for (let i = 0; i < 90; ++i) show(first + swing[i % 6]);
    places.push({ depth, force: states.slice(first, first + 4).reduce((sum, { true_fy: force }) => sum + Math.abs(force) / 4, 0) });
  }
  assert.ok(top > 0.088 && last > 40);
  return { images: path.join(held, '%06d.png'), places };
}

test('readings of a kitchen scale give the modulus within its interval, from a guess that is half of it', async () => {
  const folder = path.join(SCRATCH, 'setup-slow');
  imagesOf(BLOCK, folder, ['--override', 'operator.press.speed=2.5 mm/s', '--override', 'operator.press.depth=4.5 mm']);
  const { images, places } = stepsOf(folder, [0.9, 1.5, 2.1, 2.7, 3.3, 3.9].map((depth) => 1e-3 * depth));
  const person = await Person.open({ images, rate: 30, saved: path.join(SCRATCH, `saved-scale-${process.pid}`), off: 2, seed: 5 }), { page, stage } = person;
  try {
    await answerAll(person, { modulus: '60', identify: true });
    await person.go('check');
    await person.confirmAll();
    await page.click('#setup-use');
    await person.shows('setup-force', /^[\d.]+ N/);
    await page.click('#setup-add');
    await person.shows('setup-problems', /Hold a press first/);
    const depthNow = async () => Number((await stage.text('setup-force')).match(/at (\S+) mm/)?.[1]);
    for (const { depth, force } of places) {
      let held;
      // If a busy machine already shows the next step, the person waits until this one returns.
      await until(async () => {
        await until(async () => Math.abs((await depthNow()) - 1e3 * depth) < 0.2, `a press of ${depth}`);
        await page.waitForTimeout(800);  // a person reads the scale
        if (held) await page.click('#setup-hold');
        else await page.locator('[name="press.reading"]').press('Enter');
        await person.shows('setup-held', /are held/);
        held = Number((await stage.text('setup-held')).match(/at (\S+) mm/)[1]);
        return Math.abs(held - 1e3 * depth) < 0.3;
      }, `a held press of ${depth}`);
      const place = places.reduce((best, other) => (Math.abs(1e3 * other.depth - held) < Math.abs(1e3 * best.depth - held) ? other : best));
      await page.locator('[name="press.reading"]').fill(String(Math.round(place.force / 9.80665e-3)));
      await page.locator('[name="press.reading"]').press('Enter');
      await person.shows('setup-held', '');
    }
    await stage.shoot('setup-identify');
    const [, modulus, half] = (await stage.text('setup-modulus')).match(/modulus (\S+) kPa ± (\S+) kPa/).map(Number);
    console.log(`${await stage.text('setup-readings')}\n${modulus} ± ${half} kPa for 127 kPa`);
    assert.equal(await stage.text('setup-problems'), '');
    // The test uses three standard deviations, which are exceeded once in 370 runs, since 95 %
    // would fail once in 20. The error of the plane model of a 9 mm block is 4.9 % (check), and so
    // is that of the modulus: 1.96 times that, and 5 % of the readings.
    assert.ok(Math.abs(modulus - 127) < (3 / 1.96) * half && half < Math.hypot(0.05, 1.96 * 0.049) * 127, `${modulus} ± ${half}`);
    await page.click('#setup-use-modulus');
    await person.shows('setup-contact', /force is about/);
    const { material } = await person.answers();
    assert.ok(Number(material.modulus) > 120 && material.by === 'modulus' && Number(material.tolerance) < 6, JSON.stringify(material));
    assert.deepEqual(stage.errors, []);
  } finally {
    await person.close();
  }
});

deepTest('the printed board of the guide gives the scale within 1 %', async () => {
  const images = imagesOf(BLOCK, path.join(SCRATCH, 'setup-silicone-block')), pdf = readFileSync(path.join(ROOT, 'deploy/guides/board.pdf'), 'latin1');
  const squares = [...pdf.matchAll(/^(\S+) (\S+) 5 5 re f$/gm)].map(([, x, y]) => [Number(x), Number(y)]), px = 1 / 0.35;
  assert.equal(squares.length, 35);
  const [left, top] = [Math.min(...squares.map(([x]) => x)), Math.max(...squares.map(([, y]) => y))];
  const person = await Person.open({ images, rate: 60, saved: path.join(SCRATCH, `saved-board-${process.pid}`) }), { page } = person;
  try {
    await alterNextImage(page, { paper: [14, 180, 170, 126], boxes: squares.map(([x, y]) => [25 + px * (x - left), 192 + px * (top - y), 5 * px, 5 * px]) });
    await page.click('#setup-freeze');
    await until(async () => (await page.locator('#setup-freeze').getAttribute('data-count')) === '1', 'an image');
    await person.go('scale');
    await person.choose('scale.by', 'board');
    await person.fill('scale.square', '5');
    await page.click('#setup-board');
    await person.shows('setup-scale-fact', /mm per pixel/);
    await person.stage.shoot('setup-board');
    const pixel = Number.parseFloat(await person.stage.text('setup-scale-fact'));
    assert.ok(Math.abs(pixel / 0.35 - 1) < 0.01, `${pixel}`);
  } finally {
    await person.close();
  }
});

test('over TLS the page sets up with the certificate of an admin, and tells who has none', async () => {
  const images = imagesOf(BLOCK, path.join(SCRATCH, 'setup-silicone-block')), [slave, operator, admin] = [certificate('slave', '127.0.0.1'), certificate('operator', '127.0.0.1'), certificate('admin')];
  for (const isAdmin of [false, true]) {
    const args = ['--tls', operator, ...(isAdmin ? ['--setup-tls', admin] : [])];
    const person = await Person.open({ images, rate: 60, saved: path.join(SCRATCH, `saved-tls-${process.pid}`), slaveArgs: ['--tls', slave], view: '0.0.0.0:0', args });
    try {
      await person.freezeAtRest(TIP);
      await person.go('object');
      for (const corner of CORNERS) await person.click(corner, 0);
      if (isAdmin) await person.shows('setup-object-fact', /9\d % of the outline|100 % of the outline/);
      else await person.shows('setup-problems', /--setup-tls and the certificate of an admin/);
    } finally {
      await person.close();
    }
  }
});
