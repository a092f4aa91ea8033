// Emergency stops from the page: each arrives although the link stalls and is cut, and a page
// without connection shows this. PALPATE_STOPS: number of stops, 5 by default.
import assert from 'node:assert/strict';
import net from 'node:net';
import { after, before, describe, test } from 'node:test';

import { Stage, pause, serve, soon, until } from './stage.mjs';
import { uniform } from './setup_person.mjs';

const STOPS = Number(process.env.PALPATE_STOPS || 5), ARRIVES_MS = Number(process.env.PALPATE_ARRIVES_MS || 30000);

// A link between browser and master. While stalled it forwards nothing; while cut it drops data and
// accepts no connections.
class Link {
  constructor() {
    Object.assign(this, { sockets: new Set(), isCut: false, isStalled: false });
  }
  // Returns the address of this end. `address`: address of the master.
  async open(address) {
    const { hostname, port } = new URL(address);
    this.server = net.createServer((near) => {
      if (this.isCut) return near.destroy();
      this.join(near, net.connect(Number(port), hostname));
    });
    await new Promise((done) => this.server.listen(0, '127.0.0.1', done));
    return `http://127.0.0.1:${this.server.address().port}/`;
  }
  join(...ends) {
    for (const [from, to] of [ends, [...ends].reverse()]) {
      this.sockets.add(from);
      from.on('data', (bytes) => to.write(bytes));
      from.on('error', () => {});
      from.on('close', () => {
        this.sockets.delete(from);
        to.end();  // data that was written still arrives
      });
      if (this.isStalled) from.pause();
    }
  }
  stall() {
    this.isStalled = true;
    for (const socket of this.sockets) socket.pause();
  }
  cut() {
    this.isCut = true;
    for (const socket of this.sockets) socket.destroy();
  }
  mend() {
    this.isCut = this.isStalled = false;
    for (const socket of this.sockets) socket.resume();
  }
  close() {
    this.cut();
    this.server.close();
  }
}

describe('an emergency stop over a bad line', () => {
  const line = new Link(), random = uniform(7), upTo = (ms) => pause(ms * random());
  let stage, page;
  before(async () => {
    const slave = await serve('silicone-block', ['--override', 'model.elements=60', 'sense.camera.rate=20']);
    stage = await Stage.open({ scene: 'silicone-block', slave, log: false, size: [640, 480], line });
    ({ page } = stage);
    await page.addInitScript(() => {
      window.sockets = [];
      window.WebSocket = class extends WebSocket {
        constructor(...words) {
          super(...words);
          window.sockets.push(this);
        }
      };
    });
    await page.reload();
  });
  after(async () => {
    line.close();
    await stage?.close();
    await stage?.endSlave();
  });

  // On a busy machine the tool may not follow, so the test only requires that it is not stopped.
  const moves = () => stage.when(({ state, at }) => state !== 'ESTOP' && Date.now() - at < 1000, 'a session that is not stopped');
  // A stop that is repeated after the reset counts as a later one; a person resets again.
  const reset = async () => {
    await until(() => page.locator('#reset').isVisible(), 'the button that resets');
    await until(async () => {
      await page.keyboard.press('r');
      return soon(() => stage.status.state !== 'ESTOP');
    }, 'the end of the stop');
  };
  const press = () => page.keyboard.press('Space');
  // Waits until the browser has more than 4 kB that it cannot send.
  const fill = () => until(() => page.evaluate(() => {
    const socket = window.sockets.at(-1);
    socket.send(new Uint8Array(1 << 20));
    return socket.bufferedAmount > 4096;
  }), 'a full buffer');
  const ways = {
    'pressed while the line is cut': async () => { line.cut(); await upTo(600); await press(); await upTo(600); },
    'pressed on a line that stalls and is then cut': async () => { line.stall(); await upTo(300); await press(); await upTo(600); line.cut(); await upTo(300); },
    'pressed just before the cut': async () => { line.stall(); await press(); line.cut(); await upTo(300); },
    'pressed while the page reconnects': async () => { line.cut(); await upTo(100); line.mend(); await upTo(500); await press(); },
    'pressed while the browser cannot send': async () => { line.stall(); await fill(); await press(); line.cut(); },
  };

  test(`${STOPS} stops, none is lost`, async () => {
    const lost = [];
    for (let i = 0; i < STOPS; ++i) {
      const way = Object.keys(ways)[i % Object.keys(ways).length];
      await moves();
      await page.evaluate(() => document.activeElement.blur());
      await ways[way]();
      line.mend();
      const mended = Date.now();
      const arrived = await until(() => stage.status.at > mended && stage.status.state === 'ESTOP', '', ARRIVES_MS).catch(() => false);
      console.log(`${i + 1}: ${way}: ${arrived ? 'stopped' : 'lost'}`);
      if (arrived) await reset();
      else lost.push(way);
    }
    assert.deepEqual(lost, []);
  });

  test('the button says whether the stop is confirmed, and a reset is not sent before', async () => {
    const says = (words) => until(async () => (await page.locator('#stop small').innerText()) === words, words);
    await moves();
    await says('Esc');
    line.stall();
    await page.keyboard.press('Escape');
    await says('not confirmed');
    line.cut();
    await page.keyboard.press('r');
    await says('not confirmed');
    line.mend();
    await stage.when(({ state }) => state === 'ESTOP', 'the stop');
    await says('Esc');
    await reset();
  });

  test('a reset that waits behind other calls does not reset a later stop', async () => {
    const isRefused = () => stage.logEntries.some(({ text }) => text.startsWith('the slave did not reset the stop'));
    // On a busy machine the reset may arrive before the stop, which is then a new one. Then the
    // test repeats the race.
    await until(async () => {
      await moves();
      await page.keyboard.press('Escape');
      await until(() => page.locator('#reset').isVisible(), 'the stop');
      await page.evaluate(() => {
        for (const command of [{ do: 'model', kind: 'bem2d' }, { do: 'reset' }, { do: 'stop' }]) window.sockets.at(-1).send(JSON.stringify(command));
      });
      const refused = await soon(isRefused);
      await stage.when(({ state }) => state === 'ESTOP', 'the stop that was sent last');
      await reset();
      return refused;
    }, 'a reset that waits when the stop arrives');
  });

  test('a page whose script does not load says so, and offers to load it again', async () => {
    await page.route('**/main.js', (route) => route.abort(), { times: 1 });
    await page.reload();
    assert.ok(await page.locator('#stop').isDisabled());
    assert.equal(await page.locator('#stop small').innerText(), 'not connected');
    await page.locator('#not-started').waitFor({ state: 'visible' });
    await page.locator('#not-started a').click();
    await until(() => page.locator('#stop').isEnabled(), 'a stop that works');
    assert.equal(await page.locator('#not-started').count(), 0);
    await moves();
    await page.keyboard.press('Escape');
    await stage.when(({ state }) => state === 'ESTOP', 'the stop');
    await reset();
  });
});
