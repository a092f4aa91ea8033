// Buttons, keys, forms and tabs. No dialog ever covers the stop button.
import { keep, kept, saveImage } from './save.js';
import { minutes, write } from './text.js';

const byId = (id) => document.getElementById(id);
const PLANAR = ['auto', 'bem2d'], SOLID = ['auto', 'fem', 'fem-green'];

// Returns whether a key belongs to the focused field. A slider uses no letters.
const isOfField = ({ target, key }) =>
  /^(INPUT|SELECT)$/.test(target.tagName) && (target.type !== 'range' || /^(Arrow|Page|Home|End)/.test(key));
// Returns whether a key presses the focused element.
const pressesFocused = ({ target, key }) =>
  /^( |Enter)$/.test(key) && target.closest('button, a, select, summary, input:not([type=range])') !== null;
// Returns whether nothing has the focus but the object's view.
const isUnfocused = ({ target }) => target === document.body || target.closest('#view') !== null;

export class Controls {
  constructor({ link, view, imagePanel, pointer, charts, replay, alarms, onTheme, onShare }) {
    Object.assign(this, { link, view, imagePanel, pointer, charts, replay, alarms, onTheme, status: null });
    byId('share').addEventListener('click', onShare);
    byId('stop').addEventListener('click', () => this.stop());
    byId('reset').addEventListener('click', () => this.reset());
    byId('letters').addEventListener('change', () => keep('letters', byId('letters').checked ? 'on' : 'off'));
    byId('letters').checked = kept('letters') !== 'off';
    // The pointer's keys have no effect in the set-up.
    byId('setup-open').addEventListener('click', () => pointer.release());
    byId('pause').addEventListener('click', () => this.pause());
    byId('strips-next').addEventListener('click', () => this.charts.toggleStrips());
    byId('charts-whole').addEventListener('click', () => this.zoomCharts(0));
    byId('field').addEventListener('click', () => this.imagePanel.toggleField());
    byId('colours').addEventListener('click', () => this.view.toggleColours());
    byId('acknowledge').addEventListener('click', () => this.acknowledge());
    byId('theme').addEventListener('click', () => this.toggleTheme());
    for (const [id, act] of [
      ['let-go', 'clutch'],
      ['mark', 'mark'],
      ['tare', 'tare'],
      ['recording', 'record'],
      ['reinitialize-tracking', 'reinitializeTracking'],
    ])
      byId(id).addEventListener('click', () => this[act]());
    byId('render').addEventListener('change', () => this.link.send({ do: 'render', mode: byId('render').value }));
    byId('replace').addEventListener('submit', (event) => this.replace(event));
    for (const tab of document.querySelectorAll('[role=tab]')) {
      tab.addEventListener('click', () => this.show(tab.getAttribute('aria-controls')));
      tab.addEventListener('keydown', (event) => this.stepTab(event, tab));
    }
    window.addEventListener('keydown', (event) => this.key(event), true);
    window.addEventListener('keyup', (event) => pointer.key(event, false), true);
    charts.onZoom = () => this.showPause();
    charts.onTime = (t) => replay.active && replay.go(t);
    this.startTheme();
  }
  stop() {
    if (this.replay.active) return;  // a replay has nothing to stop
    this.pointer.release();
    this.link.stop();
    this.showStop();
  }
  // Resets a stop that is shown as confirmed. A reset is never queued, so that it cannot reset a
  // later stop.
  reset() {
    if (!this.link.isStopPending) this.link.send({ do: 'reset' });
  }
  // The stop button shows whether a stop has arrived, and how to stop. It is disabled until the
  // first message of the master.
  showStop() {
    const { isStopPending, silent } = this.link, button = byId('stop');
    if (!silent) button.disabled = false;
    write(button.lastElementChild, isStopPending ? 'not confirmed' : silent ? 'not connected' : 'Esc');
  }
  clutch() {
    this.pointer.release();
    this.link.send({ do: 'clutch', on: !this.status?.clutched });
  }
  mark() {
    this.link.send({ do: 'mark' });
  }
  tare() {
    this.link.send({ do: 'tare' });
  }
  reinitializeTracking() {
    this.link.send({ do: 'find' });
  }
  record() {
    if (this.status?.recording) this.link.send({ do: 'record', on: !this.status.recording.on });
  }
  acknowledge() {
    this.alarms.acknowledge();
  }
  nextRendering() {
    const modes = [...byId('render').options].map((option) => option.value);
    this.link.send({ do: 'render', mode: modes[(modes.indexOf(byId('render').value) + 1) % modes.length] });
  }
  // Escape stops with any focus, Space where nothing else has the focus.
  key(event) {
    if (event.key === 'Escape') return event.repeat || this.stop();
    const isLetter = event.key.length === 1 && event.key !== ' ';
    if (pressesFocused(event) || (isLetter && !byId('letters').checked)) return;
    if (event.target.id === 'strips' && this.charts.key(event)) return this.swallow(event);
    if (this.replay.key(event)) return this.swallow(event);
    if (this.replay.active && event.key === ' ') return;
    if (event.key === ' ') {
      if (!isUnfocused(event)) return;
      if (!event.repeat) this.stop();
      return this.swallow(event);
    }
    // The set-up hides the elements that the other keys act on.
    if (event.ctrlKey || event.metaKey || event.altKey || isOfField(event) || !byId('setup').hidden) return;
    if (!event.target.closest('[role=tablist]') && this.pointer.key(event, true)) return this.swallow(event);
    const act = this.actions()[event.key.toLowerCase()];
    if (!act || event.repeat) return;
    act();
    this.swallow(event);
  }
  swallow(event) {
    event.preventDefault();
    event.stopPropagation();
  }
  actions() {
    const live = this.replay.active
      ? {}
      : {
          r: () => !byId('reset').hidden && this.reset(),
          e: () => this.pointer.toggle(),
          c: () => this.clutch(),
          m: () => this.mark(),
          n: () => this.tare(),
          k: () => this.acknowledge(),
          b: () => this.record(),
          v: () => this.nextRendering(),
          1: () => this.pointer.lock(0),
          2: () => this.pointer.lock(1),
          3: () => this.pointer.lock(2),
          l: () => byId('position-scale').focus(),
          u: () => this.reinitializeTracking(),
        };
    return {
      ...live,
      f: () => this.view.fit(),
      x: () => this.view.look('X'),
      y: () => this.view.look('Y'),
      z: () => this.view.look('Z'),
      w: () => this.view.toggleWire(),
      j: () => this.imagePanel.toggleField(),
      q: () => this.view.toggleColours(),
      p: () => this.pause(),
      '+': () => this.zoomCharts(0.5),
      '-': () => this.zoomCharts(2),
      0: () => this.zoomCharts(0),
      d: () => this.charts.download(),
      i: () => saveImage(this.view),
      o: () => this.charts.toggleStrips(),
      t: () => this.toggleTheme(),
      a: () => this.show('alarms'),
      g: () => this.show('health'),
      h: () => this.show('help'),
      '?': () => this.show('help'),
    };
  }
  pause() {
    this.charts.togglePause();
    this.showPause();
  }
  // `factor` below 1 zooms in; 0: the last ten seconds.
  zoomCharts(factor) {
    this.charts.zoomBy(factor);
    this.showPause();
  }
  showPause() {
    const isPaused = Boolean(this.charts.frozen);
    byId('pause').setAttribute('aria-pressed', String(isPaused));
    byId('charts-aside').textContent = isPaused ? 'paused' : '';
  }
  show(panel) {
    for (const tab of document.querySelectorAll('[role=tab]')) {
      const chosen = tab.getAttribute('aria-controls') === panel;
      tab.setAttribute('aria-selected', String(chosen));
      tab.tabIndex = chosen ? 0 : -1;
      byId(tab.getAttribute('aria-controls')).hidden = !chosen;
    }
  }
  stepTab(event, tab) {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!step) return;
    const tabs = [...document.querySelectorAll('[role=tab]')], next = tabs[(tabs.indexOf(tab) + step + tabs.length) % tabs.length];
    next.focus();
    next.click();
  }
  replace(event) {
    event.preventDefault();
    this.link.send({ do: 'model', kind: byId('model-kind').value });
  }
  // Shows the state of clutch, rendering and recording.
  showActs(status) {
    this.status = status;
    byId('let-go').setAttribute('aria-pressed', String(status.clutched));
    if (document.activeElement !== byId('render')) byId('render').value = status.render;
    const { recording } = status, dot = byId('record');
    byId('recording').hidden = dot.hidden = !recording;
    if (!recording) return;
    byId('recording').setAttribute('aria-pressed', String(recording.on));
    dot.dataset.level = recording.trouble ? 'bad' : recording.on ? 'ok' : 'warn';
    dot.textContent = recording.trouble
      ? '■ REC ended'
      : recording.on
        ? `● REC ${minutes(status.t)} ${recording.megabytes.toFixed(1)} MB`
        : '○ not recording';
  }
  // Shows the kinds of model that this object can have.
  showKinds(model, planar) {
    const kinds = planar ? PLANAR : SOLID, list = byId('model-kind');
    if (list.dataset.kinds === String(kinds)) return;
    list.dataset.kinds = String(kinds);
    list.replaceChildren(...kinds.map((kind) => new Option(kind, kind, false, kind === model)));
  }
  startTheme() {
    const dark = matchMedia('(prefers-color-scheme: dark)');
    this.setTheme(kept('theme') || (dark.matches ? 'dark' : 'light'));
    dark.addEventListener('change', (event) => this.setTheme(event.matches ? 'dark' : 'light'));
  }
  toggleTheme() {
    const next = document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark';
    keep('theme', next);
    this.setTheme(next);
  }
  setTheme(theme) {
    document.documentElement.dataset.theme = theme;
    byId('theme').textContent = theme === 'dark' ? 'Light' : 'Dark';
    this.onTheme();
  }
}
