// What the page costs the browser, by its own trace: script a frame, what it leaves out where the processor is too slow, and
// memory over PALPATE_PAGE_MINUTES.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, describe, test } from 'node:test';

import { Stage, pause, until } from './stage.mjs';

const MINUTES = Number(process.env.PALPATE_PAGE_MINUTES || 3);
const SCRIPT = new Set(['FunctionCall', 'EvaluateScript', 'FireAnimationFrame', 'TimerFire', 'v8.callFunction', 'RunMicrotasks', 'EventDispatch']);

const share = (values, part) => values.toSorted((a, b) => a - b)[Math.min(values.length - 1, Math.floor(part * values.length))];

// The page's trace of `ms` milliseconds.
async function traced(session, ms) {
  const events = [], done = new Promise((end) => session.once('Tracing.tracingComplete', end));
  session.on('Tracing.dataCollected', ({ value }) => events.push(...value));
  await session.send('Tracing.start', { transferMode: 'ReportEvents', traceConfig: { includedCategories: ['devtools.timeline', 'v8.execute', '__metadata'] } });
  await pause(ms);
  await session.send('Tracing.end');
  await done;
  session.removeAllListeners('Tracing.dataCollected');
  return events;
}

// Of each frame of the page, from one animation frame's beginning to the next: how long its thread ran script [ms], by the
// thread's own clock, which does not go on while others have the processor.
function scriptPerFrame(events) {
  const frames = events.filter(({ name }) => name === 'FireAnimationFrame');
  const { pid, tid } = frames[0];
  const script = events.filter((event) => event.pid === pid && event.tid === tid && event.ph === 'X' && SCRIPT.has(event.name)).sort((a, b) => a.ts - b.ts || b.dur - a.dur);
  const costs = [];
  let frame = -1, end = -Infinity;
  for (const event of script) {
    if (event.ts + event.dur <= end) continue;  // within the one before
    end = event.ts + event.dur;
    while (frame + 1 < frames.length && frames[frame + 1].ts <= end) frame += 1;
    if (frame >= 0) costs[frame] = (costs[frame] || 0) + event.tdur / 1000;
  }
  return costs.slice(0, -1).map((cost) => cost || 0);
}

describe('what the page costs the browser', () => {
  let stage, session;
  before(async () => {
    stage = await Stage.open({ scene: 'silicone-block' });
    session = await stage.context.newCDPSession(stage.page);
    await until(async () => /moved by up to/.test(await stage.text('view-line')), 'a shape');
    await pause(3000);  // compiled, and at its pace
  });
  after(() => stage.close());

  test('script takes at most 6 ms a frame', async () => {
    const costs = scriptPerFrame(await traced(session, 10000));
    console.log(`script per frame: half ${share(costs, 0.5).toFixed(2)} ms, 99 % ${share(costs, 0.99).toFixed(2)} ms, longest ${Math.max(...costs).toFixed(2)} ms of ${costs.length} frames`);
    assert.ok(costs.length > 50, `${costs.length} frames`);
    assert.ok(share(costs, 0.99) <= 6, `${share(costs, 0.99)} ms`);
  });

  test('a page that had no time gets the newest, not what piled up', async () => {
    const before = stage.status.t;
    await stage.page.evaluate(() => { for (const end = performance.now() + 3000; performance.now() < end;); });
    await stage.when((status) => status.t > before + 3, 'news');
    const times = stage.statuses.map((status) => status.t).filter((t) => t >= before);
    const gaps = times.slice(1).map((t, i) => t - times[i]);
    console.log(`of 3 s without a look ${Math.max(...gaps).toFixed(2)} s were never told`);
    assert.ok(Math.max(...gaps) > 1.5, `${times}`);
  });

  test('where frames come late it draws more rarely, and again as often where they do not', async () => {
    const periods = await stage.page.evaluate(async () => {
      const { Pace } = await import('/pace.js'), pace = new Pace(33, 1000), told = [pace.period];
      for (const gap of [100, 16]) {
        for (let i = 0; i < 200; ++i) pace.see(gap);
        told.push(pace.period);
      }
      return told;
    });
    assert.deepEqual(periods, [33, 1000, 33]);
  });

  // What is left after a collection, in the page and, but for what it maps of files, in the master [MB].
  async function memory() {
    await session.send('HeapProfiler.collectGarbage');
    const { metrics } = await session.send('Performance.getMetrics');
    const of = (name) => metrics.find((metric) => metric.name === name).value;
    const master = Number(readFileSync(`/proc/${stage.master.pid}/status`, 'utf8').match(/RssAnon:\s+(\d+)/)[1]) / 1000;
    return { heap: of('JSHeapUsedSize') / 1e6, nodes: of('Nodes'), listeners: of('JSEventListeners'), master };
  }

  test(`memory is flat over ${MINUTES} minutes`, { timeout: (MINUTES + 2) * 60000 }, async () => {
    await session.send('Performance.enable');
    const taken = [];
    for (let i = 0; i < 12; ++i) {
      stage.statuses.length = 0;  // of this test
      await pause((MINUTES * 60000) / 12);
      taken.push(await memory());
    }
    const mean = (name, from, to) => taken.slice(from, to).reduce((sum, one) => sum + one[name], 0) / (to - from);
    // A status that were kept would be 4 MB a minute; lines of what happened come until there are thirty.
    for (const [name, slack] of [['heap', 1], ['nodes', 60], ['listeners', 2], ['master', 1]]) {
      const [first, last] = [mean(name, 3, 6), mean(name, 9, 12)];
      console.log(`${name}: ${first.toFixed(2)}, then ${last.toFixed(2)}`);
      assert.ok(last - first <= slack, `${name}: ${taken.map((one) => one[name].toFixed(2))}`);
    }
    assert.deepEqual(stage.errors, []);
  });
});
