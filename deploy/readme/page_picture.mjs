// The page at the deepest of a press, as README shows it; run by make_page_picture.sh.
import { test } from 'node:test';

import { Stage, pause, size } from '../../tests/page/stage.mjs';

test('a picture of the page', async () => {
  const stage = await Stage.open({ scene: process.env.PALPATE_PICTURE_SCENE, size: [1280, 720] });
  try {
    await pause(11000);  // so that the strips are full
    await stage.when((status) => size(status.chain.sent) < 0.1, 'a free hand');
    await stage.when((status) => status.state === 'FOLLOWING' && size(status.chain.sent) > 1.5, 'a press');
    await pause(600);
    await stage.shoot('page-picture');
  } finally {
    await stage.close();
  }
});
