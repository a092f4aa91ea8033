// What goes wrong ends in a sentence that says what to do, and lets the hand go: shown on the page, by real programs.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { chmodSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';

import { BIN, SCRATCH, Stage, pause, serve, size, until } from './stage.mjs';

const OTHER_RELEASE = '9.8.7', FEW = ['--override', 'model.elements=60'];

// The slave's program, which says of itself that it is of another release.
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
  // A file of 100 kB is as large as any may become: that acts as a full disk.
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
    await letGo('DISCONNECTED');  // a shorter stall is followed on within the engagement
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

  // The browser itself tells of each try to reach a master that is not there.
  test('the browser has nothing else to complain of', () => assert.deepEqual(stage.errors.filter((text) => !/WebSocket connection to .* failed/.test(text)), []));
});
