// Starts and stops slave, master and a browser on the master's page, as a person would.
import { execFileSync, spawn } from 'node:child_process';
import { createRequire } from 'node:module';
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { once } from 'node:events';
import { after } from 'node:test';
import path from 'node:path';

import { withTick } from '../../master/station/page/link.js';

export const SCRATCH = process.env.PALPATE_SCRATCH, BIN = process.env.PALPATE_BIN;
export const ROOT = path.resolve(import.meta.dirname, '../..');
const MASTER = path.join(BIN, 'palpate-master');
const need = createRequire(path.join(SCRATCH, 'package.json'));
const { chromium } = need('playwright-core');
export const AXE = readFileSync(need.resolve('axe-core/axe.min.js'), 'utf8');
// A scene with a volume takes more than a minute to start on a busy machine.
const START_MS = 180000;
export const PATIENCE_MS = 300000;  // a limit against hanging: a busy machine may take long for a step that takes a second
const SILENT_MS = 60;
const FLAGS = ['--no-sandbox', '--disable-gpu', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run',
  '--disable-background-networking', '--disable-component-update', '--disable-sync'];

export class TooBusy extends Error {}
export const pause = (ms) => new Promise((done) => setTimeout(done, ms));
export async function until(condition, what, patience = PATIENCE_MS) {
  const end = Date.now() + patience;
  while (Date.now() < end) {
    const value = await condition();
    if (value) return value;
    await pause(20);
  }
  throw new Error(`never came: ${what}${what && programs.map(stateOf).join('')}`);
}
// Records the last lines of each program, and its exit code if it has ended by itself.
const programs = [];
const stateOf = ({ spawnargs, exitCode, output }) => `\n${path.basename(spawnargs[0])} ${spawnargs[1]}, exit code ${exitCode}: ${output.slice(-400)}`;
// Returns the result of `condition` within two seconds, else null: for actions that a busy machine
// may undo and a person would repeat.
export const soon = (condition) => until(condition, '', 2000).catch(() => null);

// Starts a program that prints `pattern` when it is ready. The captured text is `address`.
async function start(program, args, pattern) {
  const child = spawn(program, args, { stdio: ['ignore', 'pipe', 'pipe'] });
  child.output = '';
  programs.push(child);
  for (const stream of [child.stdout, child.stderr]) stream.on('data', (text) => (child.output += text));
  child.ended = once(child, 'exit');
  const match = await until(() => child.output.match(pattern) || (child.exitCode !== null && ['', null]), `${program}: ${pattern}`, START_MS);
  if (match[1] === null) throw new Error(`${program} ended: ${child.output}`);
  child.address = match[1];
  return child;
}

async function end(child, signal) {
  if (!child || child.exitCode !== null) return;
  child.kill('SIGCONT');
  child.kill(signal);
  await child.ended;
  programs.splice(programs.indexOf(child), 1);
}

// Returns the folder of a new certificate of `role`. All are issued by one authority.
export function certificate(role, ...hosts) {
  const [authority, folder] = ['ca', `tls-${role}`].map((name) => path.join(SCRATCH, name)), certs = path.join(ROOT, 'deploy/certs');
  if (!existsSync(authority)) execFileSync(certs, ['ca', authority]);
  execFileSync(certs, [role, authority, folder, 'tester', ...hosts]);
  return folder;
}

// All stages of a file share one browser and those of a scene one slave, because both take seconds
// to start.
let browser = null;
const slaves = new Map();
// Starts a slave with `scene`, and the `simulator` of its sensors and manipulator. `overrides`
// apply to both.
export async function serve(scene, overrides = [], program = path.join(BIN, 'palpate-slave'), at = '127.0.0.1:0') {
  const file = path.join(ROOT, `deploy/scenes/${scene}.yaml`);
  const slave = await start(program, ['serve', file, '--listen', at, ...overrides], /^listening on (\S+)/m);
  slave.simulator = await start(path.join(BIN, 'palpate-simulator'), [file, '--slave', slave.address, ...overrides], /^streaming to (\S+)/m);
  return slave;
}
// Starts a slave that waits for a scene, with repeating `images`.
export const serveSetup = (folder, images, rate, args = []) => start(path.join(BIN, 'palpate-slave'), ['serve', '--setup', folder, '--camera', images, '--camera-rate', String(rate), '--listen', '127.0.0.1:0', ...args], /^listening on (\S+)/m);
async function endBoth(slave) {
  await end(slave?.simulator, 'SIGTERM');
  await end(slave, 'SIGTERM');
}
async function slaveOf(scene) {
  if (!slaves.has(scene)) slaves.set(scene, await serve(scene));
  return slaves.get(scene);
}
export async function endSlave(scene) {
  await endBoth(slaves.get(scene));
  slaves.delete(scene);
}
after(async () => {
  await browser?.close();
  for (const scene of [...slaves.keys()]) await endSlave(scene);
});

// Returns violations of WCAG 2.2, levels A and AA, that axe finds at the present window size.
export async function violationsOf(page) {
  if (!(await page.evaluate(() => 'axe' in window))) await page.evaluate(AXE);
  const { violations } = await page.evaluate(() => axe.run(document, { resultTypes: ['violations'], runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'] }));
  return violations.map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.html).join(' | ')}`);
}

export class Stage {
  // `slave`: a slave for this stage alone; `within`: a command that runs the master's command;
  // `line`: the link between browser and master.
  static async open({ scene, device = 'sim-hand', size = [1280, 720], scheme = 'dark', touch = false, args = [], slave, log = true, within = [], view, line }) {
    const stage = new Stage();
    stage.scene = scene;
    stage.log = path.join(SCRATCH, `${scene}-${device}.csv`);
    stage.slave = slave ?? await slaveOf(scene);
    await stage.startMaster({ device, args: log ? ['--log', stage.log, ...args] : args, within, view });
    if (line) stage.master.address = await line.open(stage.master.address);
    await stage.openBrowser(size, scheme, touch);
    return stage;
  }
  async startMaster({ device = 'sim-hand', args = [], within = [], view = '127.0.0.1:0' }) {
    const [program, ...words] = [...within, MASTER, 'connect', this.slave.address, '--device', device, ...args, '--view', view];
    this.master = await start(program, words, /view at (\S+)/);
  }
  endSlave() {
    return endBoth(this.slave);
  }
  // Opens a replay of a recording without a slave, as from another machine: with TLS and a token.
  static async replay(file, args = [], touch = false) {
    const stage = new Stage(), tls = certificate('operator', '127.0.0.1');
    stage.master = await start(MASTER, ['replay', file, ...args, '--tls', tls, '--view', '0.0.0.0:0'], /view at (\S+)/);
    await stage.openBrowser([1280, 720], 'light', touch);
    return stage;
  }
  async openBrowser([width, height], colorScheme, hasTouch = false) {
    browser ??= await chromium.launch({ executablePath: '/usr/bin/chromium', headless: true, args: FLAGS });
    this.context = await browser.newContext({ viewport: { width, height }, colorScheme, hasTouch, ignoreHTTPSErrors: true });
    this.page = await this.context.newPage();
    this.context.setDefaultTimeout(PATIENCE_MS);
    this.errors = [];
    this.statuses = [];
    this.logEntries = [];
    this.refusedEngagements = 0;
    this.page.on('console', (message) => message.type() === 'error' && this.errors.push(message.text()));
    this.page.on('pageerror', (error) => this.errors.push(String(error)));
    this.page.on('websocket', (socket) => socket.on('framereceived', ({ payload }) => this.hear(payload)));
    await this.page.goto(this.address);
  }
  // The address that the master printed; if it serves on all addresses, that of this machine.
  get address() {
    return this.master.address.replace('0.0.0.0', '127.0.0.1');
  }
  hear(payload) {
    if (typeof payload !== 'string') return;
    const message = JSON.parse(payload);
    if (message.kind === 'status') this.statuses.push({ ...withTick(message), at: Date.now() });
    if (message.kind === 'led_elsewhere') this.refusedEngagements += 1;
    if (message.kind === 'log') this.logEntries = message.entries;
    if (message.kind === 'hello' || message.kind === 'health') this[message.kind] = message;
  }
  get status() {
    return this.statuses.at(-1);
  }
  text(id) {
    return this.page.locator(`#${id}`).innerText();
  }
  // Waits until the text of `id` is `words` or matches it, because the page may draw a message
  // later than this test receives it.
  async shows(id, words) {
    let text;
    const fits = async () => ((text = await this.text(id)), words instanceof RegExp ? words.test(text) : text === words);
    await until(fits, '').catch(() => { throw new Error(`#${id} shows ${JSON.stringify(text)}, never ${words}`); });
  }
  // Waits until `selector` is visible, or is not.
  sees(selector, wanted = true) {
    return this.page.locator(selector).waitFor({ state: wanted ? 'visible' : 'hidden', timeout: PATIENCE_MS });
  }
  // Waits until the status fulfils `condition`.
  when(condition, what) {
    return until(() => this.status && condition(this.status), what).then(() => this.status);
  }
  // Throws `error`, or TooBusy if the thread of the page, which has little to do, is delayed for
  // long within four seconds.
  async explainByLoad(error) {
    const silence = await this.page.evaluate(async () => {
      let longest = 0, last = performance.now();
      const beat = setInterval(() => { [longest, last] = [Math.max(longest, performance.now() - last), performance.now()]; }, 20);
      await new Promise((done) => setTimeout(done, 4000));
      clearInterval(beat);
      return Math.round(longest);
    });
    throw silence < SILENT_MS ? error : new TooBusy(`${error.message}: the machine keeps the page silent for ${silence} ms`);
  }
  violations() {
    return violationsOf(this.page);
  }
  async shoot(name) {
    const png = await this.page.screenshot();
    writeFileSync(path.join(SCRATCH, `${name}.png`), png);
    return png;
  }
  // Returns the colours [r, g, b] at `places` [[x, y], ...] of a screenshot.
  coloursAt(png, places) {
    return this.page.evaluate(async ([base64, at]) => {
      const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
      const bitmap = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
      const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
      context.drawImage(bitmap, 0, 0);
      return at.map(([x, y]) => [...context.getImageData(Math.round(x), Math.round(y), 1, 1).data].slice(0, 3));
    }, [png.toString('base64'), places]);
  }
  async close() {
    await this.context?.close();
    await end(this.master, 'SIGTERM');
  }
  // Returns the rows of the log after the master has ended, each an object of numbers except
  // `state` and `reason`.
  readLog() {
    const [head, ...rows] = readFileSync(this.log, 'utf8').trim().split('\n').map((line) => line.split(','));
    return rows.map((row) => Object.fromEntries(head.map((name, i) => [name, name === 'state' || name === 'reason' ? row[i] : Number(row[i])])));
  }
  async endMaster() {
    await end(this.master, 'SIGTERM');
  }
}

export const size = ([x, y, z]) => Math.hypot(x, y, z);
