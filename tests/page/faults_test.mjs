// Faults of real programs: the page shows a sentence that says what to do, and the operator is disengaged.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { chmodSync, mkdirSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, afterEach, before, beforeEach, describe, test } from 'node:test';

import { Person, imagesOf } from './setup_person.mjs';
import { BIN, ROOT, SCRATCH, Stage, pause, serve, size, until } from './stage.mjs';

const OTHER_RELEASE = '9.8.7', FEW = ['--override', 'model.elements=60'];

// Makes a slave program that reports another release.
function otherRelease() {
  const program = path.join(BIN, 'palpate-slave'), version = execFileSync(program, ['--version']).toString().match(/\d+\.\d+\.\d+\+\w+/)[0];
  const release = version.split('+')[0];
  assert.equal(release.length, OTHER_RELEASE.length);
  const bytes = readFileSync(program), from = bytes.indexOf(version);
  assert.ok(from > 0, `${version} is in the program`);
  for (let at = from; at >= 0; at = bytes.indexOf(version, at + 1)) bytes.write(OTHER_RELEASE, at, 'latin1');
  const file = path.join(SCRATCH, 'palpate-slave-of-another-release');
  writeFileSync(file, bytes);
  chmodSync(file, 0o755);
  return { file, release };
}

describe('what goes wrong', () => {
  const other = otherRelease();
  let stage, another;
  // Limits files to 100 kB, which acts as a full disk.
  const full = ['sh', '-c', 'trap "" XFSZ; ulimit -f 200; exec "$@"', 'sh'];
  before(async () => {
    const slave = await serve('silicone-block', FEW, other.file);
    stage = await Stage.open({ scene: 'silicone-block', slave, log: false, within: full, args: ['--record', path.join(SCRATCH, 'full.mcap')] });
  });
  after(async () => {
    await stage.close();
    await stage.endSlave();
  });

  const pressed = () => stage.when((status) => status.state === 'FOLLOWING' && size(status.chain.sent) > 0.5, 'a press of half a newton');
  const letGo = (state) => stage.when((status) => (!state || status.state === state) && status.state !== 'FOLLOWING' && size(status.chain.sent) === 0, 'a hand that is let go');
  const shows = (...sentences) => until(async () => {
    const text = await stage.text('alarm-list');
    return sentences.every((sentence) => text.includes(sentence));
  }, sentences.join(' '));

  test('a slave of another release is served, and both are named', async () => {
    await shows(`The slave is of release ${OTHER_RELEASE}, this master of ${other.release}.`, 'Install the same release at both ends.');
    await pressed();
  });

  test('a disk that is full ends the recording, not the hand', async () => {
    await shows('The recording:', 'cannot be written', 'Free disk space');
    await until(async () => (await stage.text('record')) === '■ REC ended', 'the end of it');
    await pressed();
  });

  test('a slave that stalls lets the hand go', async () => {
    const { epoch } = await pressed();
    stage.slave.kill('SIGSTOP');
    await until(async () => /No state from the slave for more than 30 ms\.\s*The tool is stopped\. Wait, or check the network\.|No link to the slave/.test(await stage.text('alarm-list')), 'what it lacks');
    await letGo();
    // After a shorter stall motion would continue in the same engagement.
    await letGo('DISCONNECTED');
    stage.slave.kill('SIGCONT');
    assert.ok((await pressed()).epoch > epoch, 'it goes on by an engagement of its own');
  });

  test('a slave that died lets the hand go', async () => {
    await pressed();
    stage.slave.kill('SIGKILL');
    await letGo('DISCONNECTED');
    await shows('No link to the slave', 'Is palpate-slave running? The master retries by itself; engage again when the slave is back.');
  });

  test('another slave at its address is not taken up', async () => {
    const address = stage.slave.address;
    await stage.endSlave();
    another = await serve('silicone-block', [...FEW, '--override', 'name=another'], undefined, address);
    await shows('another scene is served there now, another instead of silicone-block: restart palpate-master', 'The slave answers and states the reason');
    await pause(500);
    await letGo('DISCONNECTED');
  });

  test('a master that was started anew for it is shown by the page that is open', async () => {
    const address = stage.master.address.match(/[\d.]+:\d+/)[0];
    await stage.endMaster();
    await shows('The page has no connection to the master', 'Check that palpate-master is running. The page reconnects by itself.');
    stage.slave = another;
    await stage.startMaster({ view: address });
    await until(async () => (await stage.text('scene')) === 'another', 'its name');
    await pressed();
    await until(async () => (await stage.text('alarm-list')).includes('No alarm.'), 'that it is well');
    await stage.shoot('faults-mended');
  });

  // The browser logs each attempt to reach a missing master.
  test('the browser has nothing else to complain of', () => assert.deepEqual(stage.errors.filter((text) => !/WebSocket connection to .* failed/.test(text)), []));
});

// A slave that waits for a scene gets images of a block and a tool at rest, 15 per second, until
// `silence`.
describe('a camera that goes silent while nobody operates', () => {
  const COUNT = 20, folder = path.join(SCRATCH, 'silent-camera'), source = path.join(SCRATCH, 'setup-silicone-block');
  const image = (i) => path.join(folder, `${String(i).padStart(6, '0')}.png`), first = path.join(source, 'frames/000001.png');
  const fill = (put) => {
    rmSync(folder, { recursive: true, force: true });
    mkdirSync(folder);
    for (let i = 1; i <= COUNT; ++i) put(image(i));
  };
  // Replaces each image by a pipe without writer: the camera is open and sends nothing.
  const silence = () => fill((file) => execFileSync('mkfifo', [file]));
  let stage;
  beforeEach(async () => {
    imagesOf(path.join(ROOT, 'deploy/scenes/silicone-block.yaml'), source);
    fill((file) => symlinkSync(first, file));
    ({ stage } = await Person.open({ images: path.join(folder, '%06d.png'), rate: 15, saved: path.join(SCRATCH, `saved-silent-${process.pid}`) }));
  });
  afterEach(async () => {
    await stage.close();
    stage.slave.kill('SIGKILL');  // because its thread waits for the camera
    await stage.slave.ended;
  });
  const alarms = () => stage.status.alarms.map(({ text }) => text);

  test('the set-up shows that the image is frozen, and doubts no force', async () => {
    await until(() => stage.health?.scene && stage.status, 'a slave that is watched');
    silence();
    await until(() => alarms().some((words) => /^The image has been frozen for/.test(words)), 'a frozen image');
    await stage.shows('setup-alarms', /The image has been frozen for.*Check the camera/s);
    assert.ok(!stage.statuses.some((status) => status.alarms.some(({ text }) => text.startsWith('The force is'))));
  });

  test('a scene in use is reported on the page, and the alarms of its slave are shown', async () => {
    await until(() => stage.health?.scene && stage.status, 'a slave that is watched');
    const [left, top, right, bottom] = [305, 80, 335, 124], [u, v] = [319.5, 124.757], camera = stage.health.scene.setup_camera.split('\n').filter(Boolean);
    const tip = await stage.page.evaluate(async ([base64, x, y, width, height]) => {
      const bitmap = await createImageBitmap(new Blob([Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0))]), x, y, width, height);
      const canvas = Object.assign(document.createElement('canvas'), { width, height });
      canvas.getContext('2d').drawImage(bitmap, 0, 0);
      return canvas.toDataURL('image/png').split(',')[1];
    }, [readFileSync(first).toString('base64'), left, top, right - left, bottom - top]);
    const scene = ['name: watched', 'object:', '  geometry:', '    rectangle: {width: 88 mm, height: 88 mm, thickness: 9 mm}', '  material: {young_modulus: 127 kPa, poisson_ratio: 0.49}', '  fixed: {side: bottom}',
      'tool: {shape: flat, width: 5.87 mm, depth: whole}', 'manipulator: none', 'sense:', '  camera:', ...camera.map((line) => `    ${line}`), '    pixel: 0.35 mm', '    pose: {translation: [44 mm, 54 mm, 0]}',
      `  tip: {track: template, template: tip.png, anchor: [${u - left}, ${v - top}]}`, '  contour: {track: snake}', 'model: {kind: bem2d, plane: stress, elements: 60}', ''].join('\n');
    const answer = await stage.page.evaluate(async (body) => (await fetch('/setup/use', { method: 'POST', body })).text(), JSON.stringify({ scene, files: { 'tip.png': tip } }));
    assert.notEqual(typeof JSON.parse(answer).error, 'string', answer);
    await until(() => stage.hello.scene === 'watched', 'a hello of the scene in use');
    assert.equal(stage.hello.sensor_rate, 15);
    silence();
    await until(() => alarms().some((words) => /^The slave reports: no sample from the sensor for/.test(words)), 'the alarm of the slave');
    assert.ok(stage.status.link.observes);
  });
});
