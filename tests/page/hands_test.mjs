// Who leads the hand, and whether it is led at all, is told to each page that is open.
import assert from 'node:assert/strict';
import { after, before, describe, test } from 'node:test';

import { Stage, serve, until } from './stage.mjs';

const FEW = ['--override', 'model.elements=60'];

describe('a hand and its pages', () => {
  let stage, other;
  const hint = (page) => page.locator('#hint').innerText();
  const hints = (page, words) => until(async () => words.test(await hint(page)), String(words));
  const followed = () => stage.when((status) => status.state === 'FOLLOWING', 'a hand that is followed');
  before(async () => {
    stage = await Stage.open({ scene: 'silicone-block', device: 'pointer', slave: await serve('silicone-block', FEW), log: false });
    other = await stage.context.newPage();
    await other.goto(stage.address);
    for (const page of [stage.page, other]) await hints(page, /^Drag down: /);
  });
  after(async () => {
    await stage.close();
    await stage.endSlave();
  });

  test('the page that came first leads, the other says so and takes over', async () => {
    await stage.page.keyboard.press('e');
    await followed();
    await hints(other, /^Another page leads the hand: this one takes over when that one lets go/);
    await other.keyboard.press('e');
    await stage.page.keyboard.press('e');
    await hints(stage.page, /^Another page leads the hand/);
    await followed();
    await other.keyboard.press('e');
    await stage.when((status) => status.state !== 'FOLLOWING', 'a hand that is let go');
    await hints(stage.page, /^Drag down: /);
    await other.close();
  });

  test('what was held before the slave died says that it is not followed', async () => {
    await stage.page.keyboard.press('e');
    await followed();
    const address = stage.slave.said;
    stage.slave.kill('SIGKILL');
    await stage.when((status) => status.state === 'DISCONNECTED', 'that it is gone');
    stage.slave = await serve('silicone-block', FEW, undefined, address);
    await stage.when((status) => status.state === 'READY', 'that it is back');
    await hints(stage.page, /^Held, but not followed: let go, then hold again/);
    assert.match(await stage.page.locator('#clutch').getAttribute('class'), /idle/);
    await stage.shoot('held-not-followed');
    await stage.page.keyboard.press('e');
    await stage.page.keyboard.press('e');
    await followed();
    await until(async () => !/idle/.test(await stage.page.locator('#clutch').getAttribute('class')), 'a clutch that is held');
    await stage.page.keyboard.press('e');
  });

  test('the browser has nothing to complain of', () => assert.deepEqual(stage.errors, []));
});
