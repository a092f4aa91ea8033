// The page works with every shipped scene and shows its contents. The object is pressed with the
// mouse as the page advises.
import assert from 'node:assert/strict';
import { readdirSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';

import { ROOT, Stage, endSlave, pause, size, soon, until } from './stage.mjs';

const scenes = readdirSync(path.join(ROOT, 'deploy/scenes')).filter((name) => name.endsWith('.yaml')).map((name) => name.replace('.yaml', ''));

for (const scene of scenes) {
  test(scene, async () => {
    const stage = await Stage.open({ scene, size: [1920, 1080] });
    try {
      await stage.when((status) => status.link.connected && status.slave_state, 'states');
      await until(async () => (await stage.text('scene')) === scene, 'its name');
      await until(async () => /moved by up to/.test(await stage.text('view-line')), 'a shape');
      const isSeen = await until(async () => (/ms old|s old/.test(await stage.text('image-age')) ? 'seen' : /No image: /.test(await stage.text('image-empty')) && 'pressed'), 'a picture, or why there is none');
      assert.equal(isSeen, scene.startsWith('foam') ? 'pressed' : 'seen');
      if (scene !== 'heart-target') {  // the object is not fixed, so its force is unknown
        await stage.when((status) => status.fingers.some((finger) => finger.in_contact), 'a touch');
      }
      assert.deepEqual(stage.errors, []);
      await stage.shoot(`scene-${scene}`);
    } finally {
      await stage.close();
      await endSlave(scene);
    }
  });
}

// The mouse follows only the page's hints, as a person would.
const WAYS = { down: [0, 1], up: [0, -1], 'to the left': [-1, 0], 'to the right': [1, 0] };
for (const scene of ['silicone-block', 'rubber-membrane', 'foam-cube']) {
  test(`${scene}, pressed with the mouse`, async () => {
    const stage = await Stage.open({ scene, device: 'pointer', scheme: 'light' });
    try {
      const match = await until(async () => /^Drag (down|up|to the left|to the right): /.exec(await stage.text('hint')), 'where to drag');
      await stage.shoot(`mouse-${scene}-before`);
      const [dx, dy] = WAYS[match[1]], box = await stage.page.locator('#view').boundingBox();
      const from = [box.x + (0.5 - 0.3 * dx) * box.width, box.y + (0.5 - 0.3 * dy) * box.height];
      const isHeld = () => stage.status.state === 'FOLLOWING', force = () => size(stage.status.chain.sent);
      let way = 0;
      // On a busy machine the page may be silent, which disengages the operator. Then the test
      // engages again.
      const hold = async () => {
        if (isHeld()) return;
        await stage.page.mouse.up();
        await stage.page.mouse.move(...from);
        await stage.page.mouse.down();
        way = 0;
        await soon(isHeld);
      };
      const go = async (step) => {
        await hold();
        way += step;
        await stage.page.mouse.move(from[0] + way * dx, from[1] + way * dy, { steps: 2 });
        await pause(80);
      };
      await until(async () => (await go(4), isHeld() && force() > 0.15 * stage.status.force_limit), 'a force');
      await stage.sees('.force-label');
      const pressed = force(), { validity } = stage.status.slave_state;
      await stage.shoot(`mouse-${scene}-pressed`);
      await stage.page.mouse.up();
      await stage.when((status) => size(status.chain.sent) === 0, 'a hand that is let go');
      await stage.shows('hint', /The tool is in contact: engage again/);
      await until(async () => (await go(-4), !stage.status.slave_state.local_model?.in_contact), 'the tool drawn out');
      await stage.page.mouse.up();
      await stage.shows('hint', /^(Drag |The page was silent)/);
      console.log(`${scene}: drag ${match[1]}, ${pressed.toFixed(2)} N, ${validity}`);
      assert.deepEqual(stage.errors, []);
    } finally {
      await stage.close();
      await endSlave(scene);
    }
  });
}
