// Images of the operator's page while a recorded session is replayed; run by make_pictures.sh, which joins them. Drawing
// in software would delay a live session.
import { execFileSync } from 'node:child_process';
import { test } from 'node:test';
import { mkdirSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { BIN, SCRATCH, Stage, pause, serve, size } from '../../tests/page/stage.mjs';

const CYCLE_MS = 4000;  // of the simulated operator
const SESSION_S = 32, SPEED = 0.4;  // slow, so that a browser without a graphics card draws more of it
const FOLDER = path.join(SCRATCH, 'film'), RECORDING = path.join(SCRATCH, 'film.mcap');

async function record() {
  rmSync(RECORDING, { force: true });
  const slave = await serve('silicone-block');
  try {
    execFileSync(path.join(BIN, 'palpate-master'), ['connect', slave.address, '--duration', `${SESSION_S}`, '--record', RECORDING],
      { stdio: ['ignore', 'ignore', 'inherit'] });
  } finally {
    for (const program of [slave.simulator, slave]) program.kill('SIGTERM');
    await Promise.all([slave.simulator.ended, slave.ended]);
  }
}

async function film(stage) {
  rmSync(FOLDER, { recursive: true, force: true });
  mkdirSync(FOLDER, { recursive: true });
  await stage.when((status) => size(status.chain.sent) > 1.5, 'a press');
  await stage.when((status) => size(status.chain.sent) < 0.1, 'the end of a press');
  const session = await stage.context.newCDPSession(stage.page);
  let first;
  session.on('Page.screencastFrame', ({ data, metadata, sessionId }) => {
    first ??= metadata.timestamp;
    const time = Math.round(1000 * SPEED * (metadata.timestamp - first));
    writeFileSync(path.join(FOLDER, `${String(time).padStart(6, '0')}.jpg`), Buffer.from(data, 'base64'));
    session.send('Page.screencastFrameAck', { sessionId }).catch(() => {});
  });
  await session.send('Page.startScreencast', { format: 'jpeg', quality: 92, everyNthFrame: 2 });
  await pause(2 * CYCLE_MS / SPEED);
  await session.send('Page.stopScreencast');
}

test('images of two presses', async () => {
  await record();
  const stage = await Stage.replay(RECORDING, ['--speed', `${SPEED}`]);
  try {
    await pause(12000 / SPEED);  // so that the charts are full
    await film(stage);
  } finally {
    await stage.close();
  }
});
