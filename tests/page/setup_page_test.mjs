// The set-up in a browser, as a person does it, on images of a simulated press: first with wrong answers, then until forces come.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';

import { Person, cameraOf, compare, imagesOf, processSaved, statesOf } from './setup_person.mjs';
import { ROOT, SCRATCH, until } from './stage.mjs';

// As deploy/scenes/silicone-block.yaml has it.
const toImage = cameraOf({ pixel: 0.35, centre: [44, 54] });
const CORNERS = [[0, 0], [88, 0], [88, 88], [0, 88]].map(toImage), TIP = toImage([44, 94.16]);

test("the silicone block's images, set up by clicks that are 2 px off, give the forces of the hand-written scene", async () => {
  const folder = path.join(SCRATCH, 'setup-silicone-block'), saved = path.join(SCRATCH, `saved-${process.pid}`);
  const images = imagesOf(path.join(ROOT, 'deploy/scenes/silicone-block.yaml'), folder);
  const person = await Person.sitDown({ images, rate: 60, saved, off: 2, seed: 11 }), { stage } = person;
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
    await person.boxTip(TIP, 5.87 / 0.35);
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
    await person.page.click('#setup-close');
    await stage.shows('scene', 'my-object');
    await until(async () => Number(await stage.text('magnitude')) > 1, 'the force in the station');
    await stage.shoot('setup-station');
    assert.deepEqual(stage.errors, []);
  } finally {
    await person.standUp();
  }
  const { scene, states } = processSaved(saved), hand = statesOf(folder);
  assert.equal(states.length, hand.length);
  const { worst, valid, peak } = compare(states, hand);
  console.log(readFileSync(scene, 'utf8'));
  console.log(`worst ${(100 * worst).toFixed(2)} % of the peak of ${peak.toFixed(3)} N, ${(100 * valid).toFixed(0)} % valid`);
  assert.ok(valid > 0.9 && worst < 0.03, `${worst}, ${valid} valid`);
});
