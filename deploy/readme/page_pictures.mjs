// Pictures of the operator's page, run by make_pictures.sh: station, set-up and replay at two
// widths, and images of the film of a replay. Pictures are taken only while there is no alarm,
// which takes long on a busy machine.
import { execFileSync } from 'node:child_process';
import { test } from 'node:test';
import { mkdirSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { Person, cameraOf, imagesOf } from '../../tests/page/setup_person.mjs';
import { BIN, ROOT, SCRATCH, Stage, pause, serve, size, until } from '../../tests/page/stage.mjs';

const SIZES = [[1280, 720], [390, 844]];
const CYCLE_MS = 4000;  // period of the simulated operator's presses
const SESSION_S = 24, FULL_S = 12;  // duration of the recording; time until its charts are full
// Playback speed for the film, so that a browser without a graphics card draws enough images.
const SPEED = 0.25;
const FOLDER = path.join(SCRATCH, 'film'), RECORDING = path.join(SCRATCH, 'film.mcap');
const toImage = cameraOf({ pixel: 0.35, centre: [44, 54] });  // as deploy/scenes/silicone-block.yaml has it

const isCalm = ({ alarms, link, state }) => !alarms.length && link.word === 'good' && state === 'FOLLOWING';
const forceOf = ({ chain }) => size(chain.sent);

// Takes a picture at each width while `isReady()` is true.
async function shoot(stage, name, isReady) {
  for (const [width, height] of SIZES) {
    await stage.page.setViewportSize({ width, height });
    await pause(1000);
    await until(async () => {
      if (!(await isReady())) return false;
      await stage.shoot(`${name}-${width}`);
      return isReady();
    }, `a calm moment of ${name}`);
  }
}

// Records a session that has no alarm after its charts are full.
async function record() {
  const slave = await serve('silicone-block');
  try {
    rmSync(RECORDING, { force: true });
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
  await stage.when((status) => forceOf(status) > 1.5, 'a press');
  await stage.when((status) => forceOf(status) < 0.1, 'the end of a press');
  const session = await stage.context.newCDPSession(stage.page);
  let first;
  session.on('Page.screencastFrame', ({ data, metadata, sessionId }) => {
    first ??= metadata.timestamp;
    const time = Math.round(1000 * SPEED * (metadata.timestamp - first));
    writeFileSync(path.join(FOLDER, `${String(time).padStart(6, '0')}.jpg`), Buffer.from(data, 'base64'));
    session.send('Page.screencastFrameAck', { sessionId }).catch(() => {});
  });
  await session.send('Page.startScreencast', { format: 'jpeg', quality: 92, everyNthFrame: 2 });
  const from = stage.statuses.length;
  await pause(CYCLE_MS / SPEED);
  await session.send('Page.stopScreencast');
  const troubled = stage.statuses.slice(from).find(({ alarms, link }) => alarms.length || link.word === 'degraded');
  if (troubled) throw new Error(`the film shows an alarm: ${JSON.stringify(troubled.alarms)}, ${troubled.link.word}`);
}

test('film and pictures of a replay', async () => {
  await record();
  const stage = await Stage.replay(RECORDING, ['--speed', `${SPEED}`, '--from', '1']);
  try {
    await pause((1000 * FULL_S) / SPEED);
    await film(stage);
    await stage.when((status) => forceOf(status) > 2, 'a deep press');
    await stage.page.locator('#play').click();
    await stage.when(({ replay }) => !replay.playing, 'that it pauses');
    await shoot(stage, 'replay', () => stage.page.isVisible('#field-canvas'));
  } finally {
    await stage.close();
  }
});

test('pictures of a session', async () => {
  const stage = await Stage.open({ scene: 'silicone-block', scheme: 'light' });
  try {
    await pause(1000 * FULL_S);
    const isReady = async () => isCalm(stage.status) && forceOf(stage.status) > 1.5 && (await stage.page.isVisible('#field-canvas'));
    await shoot(stage, 'station', isReady);
  } finally {
    await stage.close();
  }
});

test('pictures of the set-up', async () => {
  const images = imagesOf(path.join(ROOT, 'deploy/scenes/silicone-block.yaml'), path.join(SCRATCH, 'recorded'));
  const tip = toImage([44, 94.16]), corners = [[0, 0], [88, 0], [88, 88], [0, 88]].map(toImage);
  const person = await Person.open({ images, rate: 60, saved: path.join(SCRATCH, `saved-${process.pid}`), size: SIZES[0] }), { stage } = person;
  try {
    await person.freezeAtRest(tip);
    await person.next();
    for (const corner of corners.slice(0, 2)) await person.click(corner);
    await person.fillScale('88');
    await person.next();
    for (const [key, value] of [['width', 88], ['height', 88], ['thickness', 9]]) await person.fill(`object.${key}`, value);
    for (const corner of corners) await person.click(corner);
    await person.shows('setup-object-fact', /clear edge/);
    await person.next();
    await person.click(toImage([44, 0]));
    await person.shows('setup-held-fact', /^1 of 4/);
    await shoot(stage, 'setup', () => true);
  } finally {
    await person.close();
  }
});
