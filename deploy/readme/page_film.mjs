// Images of the operator's page while the simulated operator presses the block; run by make_pictures.sh, which joins them.
import { execSync } from 'node:child_process';
import { test } from 'node:test';
import { mkdirSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { SCRATCH, Stage, pause, size } from '../../tests/page/stage.mjs';

const CYCLE_MS = 4000;  // of the simulated operator
const ATTEMPTS = 6;
const FOLDER = path.join(SCRATCH, 'film');

// False if the force was unknown or damped meanwhile: a busy machine, which drawing makes busier.
async function film(stage) {
  rmSync(FOLDER, { recursive: true, force: true });
  mkdirSync(FOLDER, { recursive: true });
  await stage.when((status) => status.state === 'FOLLOWING' && size(status.chain.sent) > 1.5, 'a press');
  await stage.when((status) => size(status.chain.sent) < 0.1, 'the end of a press');
  const session = await stage.context.newCDPSession(stage.page), from = stage.statuses.length;
  let first;
  session.on('Page.screencastFrame', ({ data, metadata, sessionId }) => {
    first ??= metadata.timestamp;
    const time = Math.round(1000 * (metadata.timestamp - first));
    writeFileSync(path.join(FOLDER, `${String(time).padStart(6, '0')}.jpg`), Buffer.from(data, 'base64'));
    session.send('Page.screencastFrameAck', { sessionId }).catch(() => {});
  });
  await session.send('Page.startScreencast', { format: 'jpeg', quality: 92, everyNthFrame: 3 });
  await pause(2 * CYCLE_MS);
  await session.send('Page.stopScreencast');
  await session.detach();
  return stage.statuses.slice(from).every((status) => status.state !== 'HOLD' && status.felt.validity.toLowerCase() === 'valid');
}

test('images of two presses', async () => {
  const stage = await Stage.open({ scene: 'silicone-block', size: [1280, 720] });
  execSync(`renice -n 10 -g $(pgrep -P ${process.pid} chrom)`);  // drawing must not delay the slave
  try {
    await pause(11000);  // so that the charts are full
    for (let attempt = 1; !(await film(stage)); attempt++) {
      if (attempt === ATTEMPTS) throw new Error(`no undisturbed presses in ${ATTEMPTS} attempts: the machine is too busy`);
      await pause(CYCLE_MS);
    }
  } finally {
    await stage.close();
  }
});
