// Tests the operator's page with real programs: it shows the present values, stops the tool, and
// moves it as requested.
import assert from 'node:assert/strict';
import { readFileSync, rmSync } from 'node:fs';
import path from 'node:path';
import { after, before, describe, test } from 'node:test';

import { AXE, SCRATCH, Stage, TooBusy, pause, size, soon, until } from './stage.mjs';

const near = (a, b, tolerance) => a.every((part, i) => Math.abs(part - b[i]) <= tolerance);

async function seriousFindings(page) {
  await page.evaluate(AXE);
  const { violations } = await page.evaluate(() => axe.run(document, { resultTypes: ['violations'] }));
  return violations.filter(({ impact }) => impact === 'serious' || impact === 'critical').map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.html).join(' | ')}`);
}

// These tests are skipped with PALPATE_QUICK.
const deepTest = process.env.PALPATE_QUICK ? () => {} : test;

// A test is skipped with a message if the machine is too busy for it.
const testInTime = (name, body) => test(name, (t) => body().catch((error) => {
  if (!(error instanceof TooBusy)) throw error;
  t.skip(error.message);
}));
const deepTestInTime = process.env.PALPATE_QUICK ? () => {} : testInTime;

// Returns the values of rows by their time, rounded to 0.1 ms. If two ticks have the same time,
// neither is included.
function uniqueByTime(rows, value) {
  const found = new Map();
  rows.forEach((row, i) => { const key = row.t.toFixed(4); found.set(key, found.has(key) ? undefined : value(row, i)); });
  return found;
}

const HOW = /^(Drag down: |The tool is in contact: engage again)/;
const RECORDING = path.join(SCRATCH, 'page.mcap');
// The recording of a former run, which the station would not overwrite.
rmSync(RECORDING, { force: true });
const logged = (stage, text) => until(() => stage.logEntries.some((entry) => entry.text.startsWith(text)), text);
let log = [];  // log of the session with the scripted operator

describe('a scripted hand presses the block', () => {
  let stage;
  // {how, at}: time of the event in the page's window by the machine's clock [ms].
  const stops = [];
  before(async () => { stage = await Stage.open({ scene: 'silicone-block', args: ['--record', RECORDING] }); });
  after(() => stage.close());

  const pressed = () => stage.when((status) => status.state === 'FOLLOWING' && size(status.chain.sent) > 0.8, 'a press of 0.8 N');

  test('every panel comes up and moves', async () => {
    await pressed();
    await stage.shows('scene', 'silicone-block');
    await until(async () => (await stage.page.locator('#state b').innerText()) === 'FOLLOWING', 'the state');
    await until(async () => /^\d+ Hz$/.test(await stage.text('rate')), 'a rate');
    await until(async () => /^\d+ ms old$/.test(await stage.text('image-age')), 'an image');
    await until(async () => /moved by up to/.test(await stage.text('view-line')), 'a shape');
    const first = Number(await stage.text('magnitude'));
    await until(async () => Math.abs(Number(await stage.text('magnitude')) - first) > 0.05, 'a force that changes');
    await until(async () => (await stage.page.locator('.u-over').count()) === 6, 'six strips');
    await until(async () => /score 0\.\d+|score 1/.test(await stage.text('seen')), 'a score');
  });

  test('each force tells its way from the light to the hand', async () => {
    const first = (await stage.when((status) => status.trace, 'a trace')).trace;
    const { trace } = await stage.when((status) => status.trace?.sample > first.sample + 5, 'those of later images');
    const stages = ['capture', 'sensing', 'model', 'wait', 'wire', 'tick'].map((name) => trace[name]);
    assert.ok(Math.abs(stages.reduce((sum, part) => sum + part, 0) - trace.total) < 1e-6, JSON.stringify(trace));
    // The offset of the clocks is known to half a round trip. All other stages have positive
    // durations.
    for (const name of ['capture', 'sensing', 'model', 'wait', 'tick']) assert.ok(trace[name] >= -1e-6, `${name}: ${trace[name]}`);
    await until(async () => /^end-to-end latency \d+ ms: capture [\d.]+, vision [\d.]+, model/.test(await stage.text('trace')), 'the way in words');
    console.log(await stage.text('trace'));
  });

  test('the figure of the force is one that was reported at that moment', async () => {
    await pressed();
    // The page draws a status within 1.5 s, and this process may receive it later than the page.
    const from = Math.max(0, stage.statuses.length - 46);
    const shown = Number(await until(async () => /\d/.test(await stage.text('magnitude')) && stage.text('magnitude'), 'a force'));
    await until(() => stage.statuses.slice(from).some((status) => Math.abs(size(status.chain.sent) - shown) <= 0.00501), `a status with ${shown} N`);
  });

  const inField = async (page) => {
    await page.locator('#force-limit').focus();
    await page.keyboard.press('Escape');
    await page.locator('#view').focus();
  };
  const onView = async (page) => {
    await page.locator('#view').focus();
    await page.keyboard.press('Space');
  };
  for (const [how, act] of [['mouse', (page) => page.locator('#stop').click()], ['Space', onView], ['Esc in a field', inField]]) {
    test(`the emergency stop by ${how}`, async () => {
      await pressed();
      await stage.page.evaluate(() => {
        const note = () => { window.stoppedAt = Date.now(); };
        if (window.stoppedAt === undefined) for (const kind of ['click', 'keydown']) window.addEventListener(kind, note, { capture: true });
        window.stoppedAt = 0;
      });
      await act(stage.page);
      stops.push({ how, at: await stage.page.evaluate(() => window.stoppedAt) });
      await stage.when((status) => status.state === 'ESTOP' && size(status.chain.sent) === 0, 'the stop');
      await until(async () => (await stage.page.locator('#state b').innerText()) === 'ESTOP', 'the word for it');
      await until(async () => /Emergency stop/.test(await stage.text('alarm-list')), 'an alarm in words');
      await stage.page.keyboard.press('r');
      await stage.when((status) => status.state !== 'ESTOP', 'the end of the stop');
    });
  }

  testInTime('a lost line is shown', async () => {
    await pressed();
    await stage.page.evaluate(() => {
      window.lostAt = [];
      new MutationObserver(() => document.querySelector('#state b').innerText !== 'FOLLOWING' && window.lostAt.push(Date.now())).observe(document.getElementById('state'), { subtree: true, childList: true, characterData: true });
    });
    const delays = [];
    // A busy machine may show it later.
    while (delays.length < 6 && !delays.some((delay) => delay <= 300)) {
      await pressed();
      await until(async () => (await stage.page.locator('#state b').innerText()) === 'FOLLOWING', 'the state');
      await stage.page.evaluate(() => { window.lostAt.length = 0; });
      const cut = Date.now();
      stage.slave.kill('SIGSTOP');
      delays.push(await until(() => stage.page.evaluate(() => window.lostAt[0]), 'the word for it') - cut);
      await until(async () => /No state from the slave|No link to the slave/.test(await stage.text('alarm-list')), 'an alarm in words');
      stage.slave.kill('SIGCONT');
    }
    console.log(`a lost line is shown after ${delays} ms`);
    if (Math.min(...delays) > 300) await stage.explainByLoad(new Error(`shown after ${delays} ms`));
  });

  // The page may not have drawn a message yet that this test has received, and a key changes what
  // is drawn.
  const drawnClutch = (open) => until(async () => (await stage.page.locator('#let-go').getAttribute('aria-pressed')) === open, `a clutch drawn open: ${open}`);

  test('the clutch lets go and closes again, by key and by button', async () => {
    await pressed();
    await stage.page.keyboard.press('c');
    await stage.when((status) => status.clutched && status.state !== 'FOLLOWING' && size(status.chain.sent) === 0, 'an open clutch');
    await drawnClutch('true');
    await stage.page.locator('#let-go').click();
    await stage.when((status) => !status.clutched && status.state === 'FOLLOWING', 'a closed one');
  });

  test('marks, rendering and zero, by key and by button', async () => {
    await stage.page.keyboard.press('m');
    await stage.page.locator('#mark').click();
    await logged(stage, 'mark 2');
    await stage.page.keyboard.press('v');
    await drawnClutch('false');
    await stage.page.keyboard.press('c');
    await logged(stage, 'rendering interpolate');
    await stage.page.locator('#render').selectOption('local');
    await stage.when((status) => status.render === 'local', 'the rendering that was chosen');
    await stage.page.locator('#tare').click();
    await until(() => stage.logEntries.some(({ text }) => /^(not )?tared: /.test(text)), 'what came of the zero');
    await drawnClutch('true');
    await stage.page.keyboard.press('c');
    await stage.when((status) => status.state === 'FOLLOWING', 'FOLLOWING');
  });

  test('Space on a control is no stop, and letters can be switched off', async () => {
    const { page } = stage, since = stage.logEntries.at(-1).number, stops = () => stage.logEntries.filter(({ number, text }) => number > since && text === 'emergency stop from the page').length;
    const marks = stage.status.marks;
    await page.locator('#mark').focus();
    await page.keyboard.press('Space');
    await stage.when((status) => status.marks === marks + 1, 'a mark');
    await page.keyboard.press('h');
    await page.locator('#letters').focus();
    await page.keyboard.press('Space');
    assert.ok(!(await page.locator('#letters').isChecked()));
    for (const place of ['#strips', '#tab-help']) {
      await page.locator(place).focus();
      await page.keyboard.press('Space');
    }
    assert.equal(stops(), 0);
    await page.reload();
    await stage.shows('scene', 'silicone-block');
    await page.keyboard.press('m');
    await page.locator('#mark').click();
    await stage.when((status) => status.marks === marks + 2, 'the mark of the button alone');
    await page.locator('#tab-help').click();
    assert.ok(!(await page.locator('#letters').isChecked()), 'it is remembered');
    await page.locator('#letters').check();
    await page.locator('#view').focus();
    await page.keyboard.press('m');
    await stage.when((status) => status.marks === marks + 3, 'a mark by key');
    assert.equal(stops(), 0);
  });

  test('the dot tells whether it is recorded', async () => {
    await until(async () => /^● REC \d+:\d\d [\d.]+ MB$/.test(await stage.text('record')), 'the dot');
    await stage.page.keyboard.press('b');
    await until(async () => (await stage.text('record')) === '○ not recording', 'none');
    await stage.page.locator('#recording').click();
    await until(async () => /^● REC/.test(await stage.text('record')), 'the dot again');
  });

  deepTest('the limit of the force is lowered at once, and only lowered', async () => {
    const lower = async (limit) => {
      await stage.page.locator('#force-limit').fill(String(limit));
      await stage.page.locator('#mapping button').click();
    };
    let limit = 3.1;
    // Early in an engagement of the scripted operator, who disengages after each press.
    await until(async () => {
      limit -= 0.1;
      await stage.when((status) => status.state !== 'FOLLOWING', 'the end of a press');
      await stage.when((status) => status.state === 'FOLLOWING', 'the next one');
      await lower(limit.toFixed(1));
      await stage.when((status) => Math.abs(status.force_limit - limit) < 1e-6, 'a lower one');
      const at = stage.statuses.findIndex((status) => Math.abs(status.force_limit - limit) < 1e-6);
      const [before, then] = stage.statuses.slice(at - 1, at + 1);
      if (before.state !== 'FOLLOWING') return false;
      assert.equal(then.state, 'FOLLOWING', 'the hand is not let go for it');
      return true;
    }, 'a limit that is lowered while the hand follows');
    // Between two presses the slave's settings change, too.
    await logged(stage, 'scales and limit are set');
    await lower(3.2);
    await logged(stage, `the limit stays at ${Number(limit.toFixed(1))} N: a session can only lower it`);
    assert.ok(Math.abs(stage.status.force_limit - limit) < 1e-6);
    await until(async () => Math.abs(await stage.page.locator('#force-limit').inputValue() - limit) < 1e-6, 'what is in force, in its field');
  });

  deepTest('tip and rest are found anew where nobody feels it, and a stop stays', async () => {
    await pressed();
    await stage.page.keyboard.press('u');
    await logged(stage, 'tracking is not reinitialized: ');
    await until(async () => {  // between two presses
      await stage.when((status) => !status.clutched && status.state === 'FOLLOWING', 'FOLLOWING');
      await stage.when((status) => !status.slave_state.local_model?.in_contact && size(status.chain.sent) === 0, 'a tool that is free');
      await stage.page.keyboard.press('c');
      await stage.when((status) => status.state === 'CLUTCHED', 'CLUTCHED');
      await pause(200);
      if (!stage.status.slave_state.local_model?.in_contact) return true;
      await stage.page.keyboard.press('c');
      return false;
    }, 'a free tool at rest');
    await stage.page.locator('#reinitialize-tracking').click();
    await logged(stage, 'tracking is reinitialized');
    await stage.page.keyboard.press('Escape');
    await stage.when((status) => status.state === 'ESTOP', 'the stop');
    await pause(600);  // equal messages within half a second are not reported again
    const before = stage.logEntries.at(-1).number;
    await stage.page.keyboard.press('u');
    await until(() => stage.logEntries.some(({ number, text }) => number > before && text === 'tracking is reinitialized'), 'once more');
    await pause(300);
    assert.equal(stage.status.state, 'ESTOP');
    await stage.page.keyboard.press('r');
    await stage.when((status) => status.state !== 'ESTOP', 'the end of the stop');
    await drawnClutch('true');
    await stage.page.keyboard.press('c');
    await pressed();
  });

  test('alarms that were seen stay and no longer count', async () => {
    await stage.page.keyboard.press('Escape');
    await until(async () => /^[■▲] Stop: Emergency stop/m.test(await stage.text('alarm-list')), 'an alarm');
    await stage.shows('alarm-count', /^[1-9]/);
    await until(async () => {
      await stage.page.keyboard.press('k');
      return /Stop, acknowledged: Emergency stop/.test(await stage.text('alarm-list')) && (await stage.text('alarm-count')) === '';
    }, 'that it was seen');
    await stage.page.keyboard.press('r');
    await until(async () => !/Emergency stop/.test(await stage.text('alarm-list')), 'its end');
    await stage.page.keyboard.press('Escape');
    await until(async () => /Stop: Emergency stop/.test(await stage.text('alarm-list')), 'a new one, which counts');
    await stage.page.keyboard.press('r');
    await stage.when((status) => status.state !== 'ESTOP', 'the end of the stop');
  });

  deepTest('axe finds nothing serious, light and dark, small and large', async () => {
    for (const [width, height] of [[1280, 720], [1920, 1080]]) {
      await stage.page.setViewportSize({ width, height });
      for (const theme of ['dark', 'light']) {
        await until(async () => {
          if (await stage.page.evaluate((wanted) => document.documentElement.dataset.theme === wanted, theme)) return true;
          await stage.page.keyboard.press('t');
          return false;
        }, theme);
        // The result of axe depends on the theme, not on the size. Each theme is tested at one
        // size.
        if ((theme === 'dark') === (width === 1280)) assert.deepEqual(await seriousFindings(stage.page), [], `${width} x ${height}, ${theme}`);
        await until(() => stage.page.evaluate(() => document.documentElement.scrollWidth <= innerWidth && document.documentElement.scrollHeight <= innerHeight), `${width} x ${height}: nothing lies outside`);
        await until(() => stage.page.evaluate(() => document.getElementById('source').getBoundingClientRect().bottom <= document.querySelector('.facts').getBoundingClientRect().bottom), `${width} x ${height}: the scene's name is in the bar`);
        await stage.shoot(`block-${theme}-${width}`);
      }
    }
  });

  test('the browser has nothing to complain of', () => assert.deepEqual(stage.errors, []));

  test('what was shown is what the log says, and the stops let the hand go', async () => {
    const { statuses } = stage;
    await stage.endMaster();
    await until(async () => (await stage.page.locator('#state b').innerText()) === 'NO MASTER', 'the end of the line');
    for (const id of ['magnitude', 'peak', 'role']) await stage.shows(id, '-');  // unknown
    await stage.shows('validity', /not received/);
    await stage.sees('.force-label', false);
    log = stage.readLog();
    const rows = log, byTime = uniqueByTime(rows, (row) => row);
    const pairs = statuses.map((status) => [status, byTime.get(status.t.toFixed(4))]).filter(([, row]) => row);
    assert.ok(pairs.length > 0.95 * statuses.length, `${pairs.length} of ${statuses.length} are in the log`);
    for (const [status, row] of pairs) {
      assert.equal(status.state, row.state);
      for (const station of ['scaled', 'passive', 'limited', 'sent']) {
        assert.ok(near(status.chain[station], [row[`${station}_x`], row[`${station}_y`], row[`${station}_z`]], 1e-5), station);
      }
      assert.ok(near(status.p_M, [row.p_M_x, row.p_M_y, row.p_M_z], 1e-8));
    }
    // The wall clock at t = 0, from the status with the shortest delay.
    const begin = Math.min(...statuses.map((status) => status.at - 1e3 * status.t));
    const delays = stops.map(({ how, at }) => [how, Math.round(1e3 * rows.find((row) => 1e3 * row.t > at - begin && row.state === 'ESTOP' && row.sent_x === 0 && row.sent_y === 0 && row.sent_z === 0).t - (at - begin))]);
    console.log(`from the act to no force: ${delays.map(([how, ms]) => `${how} ${ms} ms`).join(', ')}`);
    assert.ok(Math.min(...delays.map(([, ms]) => ms)) <= 100, `the hand was let go after ${delays}`);
  });
});

// Downloads the charts' samples, repeatedly if a busy browser drops a download.
async function downloaded(stage) {
  const download = await until(async () => {
    const begins = stage.page.waitForEvent('download', { timeout: 5000 }).catch(() => null);
    await stage.page.keyboard.press('d');
    return begins;
  }, 'a download');
  return readFileSync(await download.path(), 'utf8').trim().split('\n').slice(1).map((row) => row.split(',').map(Number));
}

describe('its recording is played', () => {
  let stage;
  before(async () => { stage = await Stage.replay(RECORDING, ['--speed', '4']); });
  after(() => stage.close());

  test('without its token the page says what is missing', async () => {
    const stranger = await stage.context.newPage();
    await stranger.goto(stage.address.split('#')[0]);
    await until(async () => /open the address that it printed/.test(await stranger.locator('#alarm-list').innerText()), 'why not');
    await stranger.close();
  });

  test('it is marked, and nothing there stops or moves', async () => {
    await stage.when((status) => status.t > 1, 'a second of it');
    await stage.when((status) => status.trace && status.trace.total > 0, 'the way from the light to the hand');
    await stage.shows('badge', 'REPLAY');
    await stage.shows('scene', 'silicone-block');
    for (const id of ['stop', 'let-go', 'mapping', 'tare']) await stage.sees(`#${id}`, false);
    await until(async () => /moved by up to/.test(await stage.text('view-line')), 'a shape');
    await until(async () => /ms old/.test(await stage.text('image-age')), 'an image');
  });

  test('its curves are those of the chain that was logged', async () => {
    await stage.when((status) => status.t > 6, 'six seconds of it');
    await stage.page.keyboard.press('k');
    await stage.when((status) => !status.replay.playing, 'that it is paused');
    const drawn = await until(async () => {
      await pause(500);  // browsers reject downloads in quick succession
      const samples = await downloaded(stage);
      return samples.length > 300 && samples;
    }, 'three seconds of samples');
    const byTime = uniqueByTime(log, (row, i) => i);
    const force = (row, station) => size([row[`${station}_x`], row[`${station}_y`], row[`${station}_z`]]);
    let compared = 0;
    for (const [, t, scaled, sent] of drawn) {
      const i = byTime.get(t.toFixed(4));
      if (i === undefined || i < 20) continue;
      compared += 1;
      assert.ok(Math.abs(scaled - force(log[i], 'scaled')) < 1e-5, `${t} s: ${scaled} N; in the log ${log.slice(i - 3, i + 4).map((row) => `${row.t}: ${row.state} ${force(row, 'scaled')}`)}`);
      const last = log.slice(i - 15, i + 1).map((row) => force(row, 'sent'));
      assert.ok(last.some((newest) => Math.abs(newest - sent) < 1e-5), `${t} s: ${sent} N`);
    }
    assert.ok(compared > 0.9 * drawn.length, `${compared} of ${drawn.length} are in the log`);
  });

  test('what is drawn can be seen: the object, the colours of the bar, the arrow at its place', async () => {
    // Takes the middle of the longest press, because values change little around it.
    let t = 0, longest = 0, start = 0;
    log.forEach((row, i) => {
      if (row.state !== 'FOLLOWING' || size([row.sent_x, row.sent_y, row.sent_z]) < 0.8) start = i + 1;
      else if (i - start > longest) [longest, t] = [i - start, log[(i + start) >> 1].t];
    });
    const go = (place) => stage.page.evaluate((to) => {
      document.getElementById('place').value = to;
      document.getElementById('place').dispatchEvent(new Event('input'));
    }, place);
    await go(t);
    const label = stage.page.locator('.force-label');
    await until(async () => Math.abs(stage.status.t - t) < 0.05, `moment ${t}`);
    await until(async () => /[1-9]/.test(await label.innerText()), `a force at ${t} s`);
    const force = await stage.page.evaluate(() => getComputedStyle(document.documentElement).getPropertyValue('--force').trim().match(/[0-9a-f]{2}/g).map((part) => parseInt(part, 16)));
    await until(async () => {  // waits for the drawing, even on a slow machine
      const png = await stage.shoot('replay-press-1280'), at = await label.boundingBox();
      if (!at) return false;  // the former image is still drawn
      const view = await stage.page.locator('#view').boundingBox(), bar = await stage.page.locator('#view .colour-bar i').boundingBox();
      const x = bar.x + bar.width / 2;
      const [top, middle, bottom] = await stage.coloursAt(png, [[x, bar.y + 4], [x, bar.y + bar.height / 2], [x, bar.y + bar.height - 4]]);
      if (!near(top, [248, 230, 40], 25) || !near(middle, [33, 145, 140], 25) || !near(bottom, [68, 5, 88], 25)) return false;
      const grid = [], places = [];
      for (let i = 1; i < 30; ++i) for (let j = 1; j < 20; ++j) grid.push([view.x + (view.width * i) / 30, view.y + (view.height * j) / 20]);
      const seen = new Set((await stage.coloursAt(png, grid)).map(String));
      for (let i = -30; i <= 30; ++i) for (let j = -30; j <= 60; ++j) places.push([at.x - 10 + i, at.y + 14 + j]);
      const arrow = (await stage.coloursAt(png, places)).filter((pixel) => near(pixel, force, 40));
      return seen.size > 8 && arrow.length > 10;
    }, 'a canvas that is not blank, with the arrow beside its label');
  });

  test('it goes to and fro, slower and faster, by keys', async () => {
    const from = stage.status.t;
    await stage.page.keyboard.press('ArrowLeft');
    const back = await stage.when((status) => status.t < from - 0.5, 'a second back');
    assert.ok(Math.abs(from - back.t - 1) < 0.1, `${from} s, ${back.t} s`);
    const [first, last] = await until(async () => {
      const drawn = await downloaded(stage);
      return drawn.length > 1 && drawn[0][1] < Math.max(0.1, back.t - 9) && [drawn[0][1], drawn.at(-1)[1]];
    }, 'charts of what was before');
    assert.ok(last <= back.t + 1e-6 && last - first < 10.1, `${first} to ${last} s`);
    const row = log.reduce((best, one) => (Math.abs(one.t - back.t) < Math.abs(best.t - back.t) ? one : best));
    assert.ok(Math.abs(size(back.chain.sent) - size([row.sent_x, row.sent_y, row.sent_z])) < 1e-5);
    // Before any contact there is no peak, and no later image or shape.
    await stage.page.keyboard.press('Home');
    await stage.when((status) => status.t < 0.1, 'its beginning');
    await until(async () => Number(await stage.text('peak')) < 0.05, 'no peak of later');
    for (const id of ['image-age', 'model-age']) await until(async () => /^(\d+ ms old)?$/.test(await stage.text(id)), id);
    await stage.shows('view-line', /^(?!.*moved by up to [1-9])/);
    await stage.page.keyboard.press('[');
    await stage.when((status) => status.replay.speed === 2, 'half of it');
    await stage.page.keyboard.press('End');
    await stage.when((status) => status.replay.seconds - status.t < 0.05, 'its end');
    await stage.page.keyboard.press('Home');
    await stage.when((status) => status.t < 0.1, 'its beginning');
    await stage.page.keyboard.press('Space');
    await stage.when((status) => status.replay.playing && status.t > 0.5, 'that it plays');
    await logged(stage, 'FOLLOWING');
    assert.deepEqual(await seriousFindings(stage.page), []);
    await stage.shoot('replay-light-1280');
    assert.deepEqual(stage.errors, []);
  });
});

describe('a mouse feels the block', () => {
  let stage, middle;
  before(async () => { stage = await Stage.open({ scene: 'silicone-block', device: 'pointer', scheme: 'light' }); });
  after(() => stage.close());

  test('the page says how', async () => {
    await stage.when((status) => status.state === 'READY', 'the master');
    await until(async () => /moved by up to/.test(await stage.text('view-line')), 'a shape');
    await stage.shows('hint', HOW);
    await stage.page.keyboard.press('Space');
    await until(async () => /^Stopped: dragging moves nothing/.test(await stage.text('hint')), 'why it does not answer');
    await stage.page.keyboard.press('r');
    await until(async () => HOW.test(await stage.text('hint')), 'that it answers again');
    const box = await stage.page.locator('#view').boundingBox();
    middle = [box.x + box.width / 2, box.y + box.height / 2];
  });

  // If a busy machine silences the page for longer than its limit, the master disengages it, as
  // required. Then the gesture is repeated.
  const byHand = (gesture, what) => until(gesture, what).catch((error) => stage.explainByLoad(error));

  // Holds the button in the middle of the view until the tool follows in a new engagement.
  const press = () => byHand(async () => {
    await stage.page.mouse.up();
    await stage.page.mouse.move(...middle);
    if (!(await soon(() => stage.status.state !== 'FOLLOWING'))) return false;
    await stage.page.mouse.down();
    return soon(() => stage.status.state === 'FOLLOWING' && stage.status);
  }, 'FOLLOWING by mouse');

  // Presses and drags down until the force is half a newton.
  const pressDown = async () => {
    let depth = 0;
    await press();
    await byHand(async () => {
      if (stage.status.state !== 'FOLLOWING') {
        depth = 0;
        await press();
      }
      depth += 3;
      await stage.page.mouse.move(middle[0], middle[1] + depth, { steps: 3 });
      await pause(100);
      return size(stage.status.chain.sent) > 0.5;
    }, 'half a newton');
  };

  testInTime('a drag moves the tool as far as the cursor goes, and the arrow answers', async () => {
    await byHand(async () => {
      const from = (await press()).p_S;
      await stage.page.mouse.move(middle[0] + 10, middle[1], { steps: 5 });
      // Absent before the first drawing.
      const scale = Number(await stage.page.locator('#view').getAttribute('data-metres-per-pixel'));
      return soon(() => {
        const { state, p_S } = stage.status, [aside, up] = [p_S[0] - from[0], p_S[1] - from[1]];
        return state === 'FOLLOWING' && Math.abs(aside - 10 * scale) < scale && Math.abs(up) < 2 * scale;
      });
    }, 'ten pixels to the right, and nowhere else');
    await pressDown();
    const label = stage.page.locator('.force-label');
    await label.waitFor({ state: 'visible' });
    await until(async () => /pointer delay \d+ ms/.test(await stage.text('page-delay')), 'its own delay');
    await stage.shoot('pointer-light-1280');
    console.log(await stage.text('page-delay'));
  });

  // All moves happen in one task of the page, in which its 20 ms timer does not run. So only the
  // moves send reports.
  testInTime('each move of the cursor is sent, at most every 8 ms, and none is lost', async () => {
    const drag = (x, y) => {
      const view = document.getElementById('view'), { send } = WebSocket.prototype, messages = [];
      if (!view.classList.contains('held')) return null;
      WebSocket.prototype.send = function (data) {
        if (typeof data === 'string' && JSON.parse(data).do === 'pointer') messages.push(JSON.parse(data));
        return send.call(this, data);
      };
      const move = (after) => {
        for (const end = performance.now() + after; performance.now() < end;);
        view.dispatchEvent(new PointerEvent('pointermove', { clientX: (x += 1), clientY: y }));
      };
      for (let i = 0; i < 10; ++i) move(9);
      const each = messages.length;
      for (let i = 0; i < 20; ++i) move(1);
      const byMoves = messages.length;
      return new Promise((done) => setTimeout(() => {
        WebSocket.prototype.send = send;
        done({ each, byMoves, messages });
      }, 50));
    };
    const { each, byMoves, messages } = await byHand(async () => (await press()) && stage.page.evaluate(`(${drag})(${middle})`), 'moves');
    assert.equal(each, 10, 'those that are 9 ms apart');
    const gaps = messages.slice(1, byMoves).map(({ at }, i) => at - messages[i].at), [first, last] = [messages[0], messages.at(-1)].map(({ p_M }) => p_M[0]);
    assert.ok(Math.min(...gaps) >= 8, `sent after ${gaps} ms`);
    const scale = Number(await stage.page.locator('#view').getAttribute('data-metres-per-pixel')) / stage.status.position_scale;
    assert.ok(Math.abs(last - first - 29 * scale) < scale / 10, `${last - first} m, of ${29 * scale} m`);
    await stage.page.mouse.up();
  });

  testInTime('a page that is loaded anew in contact holds nothing, says how to hold again, and knows what was', async () => {
    await pressDown();
    const until_then = stage.status.t;
    await stage.page.reload();
    await stage.when((status) => status.t > until_then && status.state === 'CLUTCHED' && size(status.chain.sent) === 0, 'CLUTCHED');
    await until(async () => HOW.test(await stage.text('hint')), 'how');
    await until(async () => (await downloaded(stage)).some(([, t, , sent]) => t < until_then && sent > 0.3), 'the force that was');
    await until(async () => /moved by up to/.test(await stage.text('view-line')), 'a shape');
    await stage.page.mouse.up();
  });

  testInTime('letting go lets go', async () => {
    await press();
    await stage.page.mouse.up();
    await stage.when((status) => status.state === 'CLUTCHED' && size(status.chain.sent) === 0, 'CLUTCHED');
  });

  // Half of the time the page's thread is blocked for longer than the limit of a browser that is in
  // time.
  test('a browser that is often late keeps its engagement', async () => {
    await stage.page.evaluate(() => {
      window.blocks = 0;
      window.late = setInterval(() => {
        for (const end = performance.now() + 300; performance.now() < end;);
        window.blocks += 1;
      }, 600);
    });
    const blocks = () => stage.page.evaluate(() => window.blocks);
    await until(async () => (await blocks()) > 1, 'a late timer');
    await until(async () => {
      const { epoch } = await press(), before = await blocks();
      await until(async () => (await blocks()) > before + 4, 'more of it');
      return stage.status.state === 'FOLLOWING' && stage.status.epoch === epoch;
    }, 'an engagement that outlasts late timers');
    await stage.page.evaluate(() => clearInterval(window.late));
    await stage.page.mouse.up();
  });

  // The page is blocked for longer than the limit of any browser.
  test('a page that was silent for too long says for how long, and engages again', async () => {
    await until(async () => {
      await press();
      await stage.page.evaluate(() => { for (const end = performance.now() + 1500; performance.now() < end;); });
      return soon(async () => Number((await stage.text('hint')).match(/^The page was silent for (\d+) ms, so the operator was disengaged: engage again\./)?.[1]) > 1000);
    }, 'that the page was silent');
    await press();
    await until(async () => !/silent/.test(await stage.text('hint')), 'that it is engaged again');
    await stage.page.mouse.up();
    await stage.when((status) => status.state === 'CLUTCHED', 'CLUTCHED');
  });

  // The other page draws nothing, so its thread is free to send in time.
  testInTime('only one page leads: another lets go at once, says why, and leads when the first has let go or fell silent', async () => {
    const another = await stage.context.newPage();
    await another.goto(new URL('style.css', stage.address).href);
    const other = (wanted) => another.evaluate((engaged) => {
      window.other ??= new WebSocket(`ws://${location.host}/ws`);
      clearInterval(window.beat);
      if (engaged === null) return;
      const beat = () => window.other.send(JSON.stringify({ do: 'pointer', at: performance.now(), p_M: [0, 0, 0], engaged }));
      beat();
      if (engaged) window.beat = setInterval(beat, 20);
    }, wanted);
    const isHeld = () => stage.page.evaluate(() => document.getElementById('view').classList.contains('held'));
    await other(null);
    await until(() => another.evaluate(() => window.other.readyState === WebSocket.OPEN), 'another page');
    await stage.page.bringToFront();
    await stage.page.mouse.move(...middle);
    for (const ends of [() => other(false), () => other(null)]) {
      // Repeated if the master reports that the other page was silent for too long.
      await byHand(async () => {
        await stage.page.mouse.up();
        await other(false);
        if (!(await soon(() => stage.status.state !== 'FOLLOWING'))) return false;
        await other(true);
        if (!(await soon(() => stage.status.state === 'FOLLOWING'))) return false;
        const refused = stage.refusedEngagements;
        await stage.page.mouse.down();  // a busy page handles it later
        return soon(async () => stage.refusedEngagements > refused && !(await isHeld()) && /^Another page controls the tool/.test(await stage.text('hint')));
      }, 'a page that lets go because another one leads, and says so');
      await ends();
      await stage.when((status) => status.state !== 'FOLLOWING', 'nobody leads');
      await pause(300);
      assert.notEqual(stage.status.state, 'FOLLOWING', `the button that is still down takes nothing ${JSON.stringify(stage.statuses.slice(-40).map((s) => [s.t, s.state, s.pointer_holds, s.pointer_used]))} ${await isHeld()}`);
      await press();
      await stage.page.mouse.up();
      await stage.when((status) => status.state === 'CLUTCHED', 'CLUTCHED');
    }
    await another.close();
  });

  testInTime('keys move it too, and losing the focus lets go', async () => {
    await stage.page.locator('#view').focus();
    const from = stage.status.p_S[1];
    // E also disengages, so it is pressed again only if it did not engage.
    const hold = async () => {
      if (stage.status.state === 'FOLLOWING') return;
      await stage.page.keyboard.press('e');
      await soon(() => stage.status.state === 'FOLLOWING');
    };
    await byHand(async () => {
      await hold();
      await stage.page.keyboard.down('ArrowUp');  // as when a held key repeats
      await pause(200);
      return stage.status.p_S[1] > from + 1e-3;
    }, 'a millimetre up by keys');
    await stage.page.keyboard.up('ArrowUp');
    await stage.page.keyboard.press('1');
    await stage.page.evaluate(() => {
      const { send } = WebSocket.prototype;
      window.aims = [];
      WebSocket.prototype.send = function (data) {
        if (typeof data === 'string' && JSON.parse(data).do === 'pointer') window.aims.push(JSON.parse(data).p_M);
        return send.call(this, data);
      };
      window.restoreSend = () => { WebSocket.prototype.send = send; };
    });
    let begun = null;  // start of this engagement; another one begins at the present tip position
    await byHand(async () => {
      await hold();
      const { epoch, p_S } = stage.status;
      if (begun?.epoch !== epoch) begun = { epoch, p_S };
      for (const key of ['ArrowUp', 'ArrowRight']) await stage.page.keyboard.down(key);
      await pause(200);
      const now = stage.status;
      return now.epoch === epoch && now.p_S[1] > begun.p_S[1] + 1e-3 && now;
    }, 'another millimetre up');
    const aims = await stage.page.evaluate(() => { window.restoreSend(); return window.aims; });
    // The object deflects the device, so the lock is tested on the target.
    const [aside, up] = [0, 1].map((axis) => Math.max(...aims.map((p) => p[axis])) - Math.min(...aims.map((p) => p[axis])));
    assert.ok(aside === 0 && up > 0, `x is locked: aimed ${aside} m aside, ${up} m up`);
    for (const key of ['ArrowUp', 'ArrowRight']) await stage.page.keyboard.up(key);
    await stage.page.keyboard.press('1');
    await stage.page.evaluate(() => window.dispatchEvent(new Event('blur')));
    await stage.when((status) => status.state === 'CLUTCHED', 'CLUTCHED');
  });

  deepTestInTime('sliders of the scales wait until nobody feels the change, and then nothing jumps', async () => {
    const { page } = stage, { force_scale, position_scale } = stage.status;
    const right = async (slider, times) => {
      await page.locator(slider).focus();
      for (let i = 0; i < times; ++i) await page.keyboard.press('ArrowRight');
    };
    await pressDown();
    await right('#force-scale', 2);
    await stage.when((status) => status.waiting.force_scale !== null, 'that it waits');
    await until(async () => /^… [\d.]+ N\/N$/.test(await stage.text('force-scale-value')), 'that it waits');
    await page.mouse.up();
    await stage.when((status) => status.state === 'CLUTCHED', 'CLUTCHED');
    await pause(300);
    assert.equal(stage.status.force_scale, force_scale, 'the tool touches');
    await byHand(async () => {  // lifts the tool off
      if (!(await press())) return false;
      await page.mouse.move(middle[0], middle[1] - 120, { steps: 10 });
      await soon(() => !stage.status.slave_state.local_model?.in_contact);
      await page.mouse.up();
      return soon(() => stage.status.state === 'CLUTCHED' && !stage.status.slave_state.local_model?.in_contact);
    }, 'a free tool');
    const set = await stage.when((status) => Math.abs(status.force_scale / force_scale - 10 ** 0.1) < 0.01, 'the scale that was asked for');
    assert.equal(set.waiting.force_scale, null);
    await page.keyboard.press('l');
    await until(() => page.evaluate(() => document.activeElement.id === 'position-scale'), 'its slider');
    await right('#position-scale', 2);
    const tip = Object.values(stage.status.slave_state.p_S_tip);
    await stage.when((status) => Math.abs(status.position_scale / position_scale - 10 ** 0.1) < 0.01, 'the other, at once');
    await until(async () => (await stage.text('position-scale-value')) === '1.26 mm/mm', 'in figures');
    await until(async () => (await page.locator('#position-scale').getAttribute('aria-valuetext')) === '1 mm of the device is 1.26 mm of the tool', 'in words');
    assert.ok(near((await press()).p_S, tip, 2e-4), `engaged at ${stage.status.p_S}, the tool was at ${tip}`);
    await page.mouse.up();
  });

  testInTime('a page that is gone holds nothing', async () => {
    await press();
    assert.deepEqual(stage.errors, []);
    await stage.page.close();
    await pause(1000);
    await stage.endMaster();
    const rows = stage.readLog(), last = rows.filter((row) => row.t > rows.at(-1).t - 0.3);
    const force = (row) => [row.sent_x, row.sent_y, row.sent_z];
    rows.slice(1).forEach((row, i) => {
      const ticks = Math.max(1, Math.ceil((row.t - rows[i].t) / 1e-3 - 0.2));
      assert.ok(size(force(row).map((part, axis) => part - force(rows[i])[axis])) <= 0.2 * ticks + 1e-4, `the force jumps at ${row.t} s`);
    });
    assert.ok(rows.some((row) => row.state === 'FOLLOWING') && last.every((row) => row.state !== 'FOLLOWING'), 'nobody follows any more');
  });
});
