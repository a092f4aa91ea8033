// The page comes up with every scene that is shipped, and shows what there is to see.
import assert from 'node:assert/strict';
import { readdirSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';

import { ROOT, Stage, endSlave, until } from './stage.mjs';

const scenes = readdirSync(path.join(ROOT, 'deploy/scenes')).filter((name) => name.endsWith('.yaml')).map((name) => name.replace('.yaml', ''));

for (const scene of scenes) {
  test(scene, async () => {
    const stage = await Stage.open({ scene, size: [1920, 1080] });
    try {
      await stage.when((status) => status.link.connected && status.felt, 'states');
      await until(async () => (await stage.text('scene')) === scene, 'its name');
      await until(async () => /moved by up to/.test(await stage.text('view-line')), 'a shape');
      const isSeen = await until(async () => (/ms old|s old/.test(await stage.text('picture-age')) ? 'seen' : /No picture: /.test(await stage.text('picture-empty')) && 'felt'), 'a picture, or why there is none');
      assert.equal(isSeen, scene.startsWith('foam') ? 'felt' : 'seen');
      if (scene !== 'heart-target') {  // nothing holds it: its force is unknown
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
