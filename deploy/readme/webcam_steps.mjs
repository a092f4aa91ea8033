// Makes images of the steps of the guide "A webcam in fifteen minutes", with the answers of its
// example; run by make_webcam.sh.
import { test } from 'node:test';
import { readdirSync, rmSync } from 'node:fs';
import path from 'node:path';

import { Person, cameraOf, imagesOf } from '../../tests/page/setup_person.mjs';
import { ROOT, SCRATCH, until } from '../../tests/page/stage.mjs';

const toImage = cameraOf({ pixel: 0.35, centre: [44, 54] });  // as deploy/scenes/silicone-block.yaml has it
const CORNERS = [[0, 0], [88, 0], [88, 88], [0, 88]].map(toImage), TIP = toImage([44, 94.16]);

test('an image of each step', async () => {
  for (const name of readdirSync(SCRATCH).filter((file) => /^step-.*\.png$/.test(file))) rmSync(path.join(SCRATCH, name));
  const images = imagesOf(path.join(ROOT, 'deploy/scenes/silicone-block.yaml'), path.join(SCRATCH, 'recorded'));
  const person = await Person.open({ images, rate: 60, saved: path.join(SCRATCH, `saved-${process.pid}`), size: [1000, 640] }), { page, stage } = person;
  let step = 0;
  const show = () => page.locator('#setup').screenshot({ path: path.join(SCRATCH, `step-${++step}.png`) });
  try {
    await person.freezeAtRest(TIP);
    await show();
    await person.next();
    for (const corner of CORNERS.slice(0, 2)) await person.click(corner);
    await person.fillScale(88);
    await show();
    await person.next();
    for (const [key, value] of [['width', 88], ['height', 88], ['thickness', 9]]) await person.fill(`object.${key}`, value);
    for (const corner of CORNERS) await person.click(corner);
    await person.shows('setup-object-fact', /clear edge/);
    await show();
    await person.next();
    await person.click(toImage([44, 0]));
    await show();
    await person.next();
    await person.fill('material.modulus', 127);
    await show();
    await person.next();
    await person.fill('tool.width', 5.87);
    await person.choose('tool.by', 'whole');
    await person.boxTip(TIP, 5.87 / 0.35);
    await person.shows('setup-tool-fact', /^Tip found/);
    await show();
    await person.next();
    await person.shows('setup-contact', /force is about/);
    await show();
    await person.confirmAll();
    await page.click('#setup-use');
    await until(async () => /depth so far: [3-9]/.test(await stage.text('setup-largest')), 'a press');
    await until(async () => /^[1-9].* N ± /.test(await stage.text('setup-force')), 'a force');
    await show();
  } finally {
    await person.close();
  }
});
