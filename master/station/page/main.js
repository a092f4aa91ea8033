// The operator's page shows messages of the master and sends commands of the operator.
import { AlarmPanel, alarmsOf } from './alarms.js';
import { Charts } from './charts.js';
import { ColourScale } from './colours.js';
import { Controls } from './controls.js';
import { ForcePanel } from './force.js';
import { showHealth } from './health.js';
import { Link, fieldOf, fieldTopologyOf } from './link.js';
import { Pace } from './pace.js';
import { ImagePanel } from './image_panel.js';
import { Pointer } from './pointer.js';
import { ReplayBar } from './replay.js';
import { Scales, mappingOf } from './scales.js';
import { Setup } from './setup.js';
import { Share } from './share.js';
import { View } from './view.js';
import { STATES, fixed, ms, unconnected, write } from './text.js';

const byId = (id) => document.getElementById(id);
const MARK = { bad: '■', warn: '▲', idle: '●', ok: '✓', off: '○' };
const DRAG = 'the tool, the ball, follows the cursor. Press it against the object.',
  PINCH = 'the finger, the ball, follows the cursor, and the others pinch with it.';
const latest = { hello: null, health: null, status: null, lost: 'connecting', why: '' };

const link = new Link(take, (reason) => showLink(reason), () => showLink(null));
const colourScale = new ColourScale();
const view = new View(link, colourScale),
  imagePanel = new ImagePanel(link, colourScale),
  force = new ForcePanel(),
  charts = new Charts(),
  alarms = new AlarmPanel();
const pointer = new Pointer(link, view, mapping),
  replay = new ReplayBar(link),
  scales = new Scales(link, view.host),
  setup = new Setup(imagePanel),
  share = new Share();
let controls = null, changed = true;
byId('not-started').remove();
controls = new Controls({ link, view, imagePanel, pointer, charts, replay, alarms, onTheme, onShare });

// While the charts pause, image and object show the time of the cursor.
charts.onCursor = (t) => {
  const past = t === null ? null : { ...share.momentAt(t), words: `paused at ${(t - charts.end).toFixed(2)} s` };
  for (const panel of [imagePanel, view]) panel.showPast(past);
};

function onTheme() {
  view.repaint();
  if (charts.uPlot) charts.draw();
  charts.changed = true;
}

// Exports one contact as one file, which can be viewed without Palpate.
async function onShare() {
  const button = byId('share'), scene = latest.health?.scene;
  button.disabled = true;
  write(byId('charts-aside'), 'saving ...');
  const isSaved = await share.save(scene, `palpate ${scene?.name || latest.hello?.scene || 'press'}`);
  button.disabled = false;
  controls.showPause();
  if (!isSaved) write(byId('charts-aside'), 'nothing to share yet');
}

function mapping() {
  return mappingOf(latest.status, latest.health?.scene, latest.hello);
}

const handlers = {
  hello(message) {
    charts.begin();  // after a restart of the master, a lost connection, or another scene
    share.begin();
    charts.onCursor(null);
    if (!latest.hello) {
      view.load(message.libraries);
      charts.load(message.libraries);
    }
    latest.hello = message;
    imagePanel.forget();
    view.forgetShape();
    pointer.enable(message.pointer);
    replay.enable(message.badge === 'REPLAY');
    if (replay.active) link.forgetStop();
    else link.send({ do: 'field', on: imagePanel.showsField });
    latest.why = '';
    showHint();
  },
  health(message) {
    latest.health = message;
    view.forceScale = mapping().force_scale;
    view.takeWorkspace(message.scene?.capabilities);
    setup.takeHealth(message);
  },
  past(message) { charts.takePast(message); },
  log(message) { alarms.showLog(message.entries); },
  refused(message) {
    latest.why = message.text;
    showHint();
  },
  led_elsewhere() {
    pointer.yieldControl();
    showHint();
  },
  status(message) {
    latest.status = message;
    pointer.take(message);
    const why = pointer.releaseIfHeld(message);
    if (why || pointer.engaged) latest.why = why || '';  // clears the reason after an engagement
    showHint();
    view.take(message);
    setup.takeStatus(message);
    const { score = null, misfit = null } = message.slave_state?.details || {};
    charts.take(message.samples.map((sample) => [...sample, score, misfit]), message.replay?.run);
    share.takeStatus(message);
    charts.takeEvents(share.events);
    if (charts.asksPast(performance.now())) link.send({ do: 'past' });
    replay.show(message);
  },
  image(message) {
    imagePanel.take(message);
    share.takeImage(message);
  },
  topology(message) { view.takeTopology(message); },
  shape(message) {
    view.takeShape(message);
    share.takeShape(message);
  },
  field_topology(message) {
    const topology = fieldTopologyOf(message);
    for (const part of [view, imagePanel, share]) part.takeFieldTopology(topology);
  },
  field(message) {
    const field = imagePanel.topology && fieldOf(message, imagePanel.topology);
    if (field) for (const part of [view, imagePanel, share]) part.takeField({ ...field, number: message.number });
  },
};

function take(kind, message) {
  const before = latest.status?.state;
  handlers[kind]?.(message);
  changed = true;
  if (latest.status?.state !== before) showState();  // without delay, even on a busy page
}

// Shows what to do in the object's view, or why it does not respond.
function showHint() {
  write(byId('hint'), latest.hello?.pointer ? hint(latest.status) : latest.why);
}

const ALONE = 'This master observes: it was started without a device for a real tool.';
function hint(status) {
  if (status?.link.observes && latest.hello?.only_observes) return ALONE;
  if (status?.link.observes) return 'The slave has no manipulator: it observes a tool that somebody else moves.';
  if (status?.state === 'STOP_REQUESTED') return 'Emergency stop requested: the slave has not confirmed it.';
  if (status?.state === 'ESTOP') return 'Stopped: dragging moves nothing until the stop is reset (R).';
  if (pointer.isLedElsewhere) return 'Another page controls the tool: engage here after it has disengaged.';
  if (pointer.isIdle && status?.state === 'READY') return 'Engaged, but the tool does not follow: disengage, then engage again.';
  const inside = status?.slave_state?.local_model?.in_contact
    ? 'The tool is in contact: engage again to press further or to retract it.'
    : '';
  const way = view.wayToPress(), fingers = status?.fingers.length > 1;
  return [latest.why, inside].filter(Boolean).join(' ') || `Drag ${way || 'here'}: ${fingers ? PINCH : DRAG}`;
}

function showLink(lost) {
  latest.lost = lost;
  changed = true;
  if (lost) forget();
  showState();
}

// Without messages of the master the page shows no value.
function forget() {
  latest.status = null;
  force.forget();
  view.forget();
  byId('record').hidden = true;
}

function showState() {
  const { status, lost } = latest;
  let [level, words] = status ? STATES[status.state] : ['off', 'waiting for the first tick'];
  let name = status?.state || 'STARTING';
  if (status?.link.observes)
    [level, name, words] = [
      'idle',
      'OBSERVING',
      latest.hello?.only_observes ? ALONE : latest.health?.scene?.name ? 'no manipulator: nobody can move the tool' : 'set-up: the slave has no scene yet',
    ];
  if (lost) [level, name, words] = ['bad', 'NO MASTER', lost];
  const line = status?.link;
  if (status?.state === 'DISCONNECTED' && !line.observes && line.word === 'connected' && !lost)
    [level, name, words] = ['warn', 'CONNECTED', 'the slave answers, but sends no states'];
  if (!lost && line?.word === 'degraded') [level, words] = [level === 'bad' ? level : 'warn', `${words}; degraded: ${line.why}`];
  const chip = byId('state');
  chip.dataset.level = level;
  const [mark, title, more] = chip.children;
  write(mark, MARK[level]);
  write(title, name.replaceAll('_', ' '));
  write(more, words);
  more.title = words;
  byId('reset').hidden = Boolean(lost) || status?.state !== 'ESTOP' || link.isStopPending;
  controls.showStop();
  document.body.classList.toggle('lost', Boolean(lost));
}

function showFacts() {
  const { hello, status, lost } = latest;
  const line = lost ? null : status?.link;
  const set = (id, text, level = '') => {
    write(byId(id), text);
    if (byId(id).dataset.level !== level) byId(id).dataset.level = level;
  };
  set('rtt', ms(line?.round_trip ?? NaN));
  set('rtt-more', line?.rtt_p99 ? `median ${fixed(1e3 * line.rtt_p50, 1)}, 99 % ${ms(line.rtt_p99)}` : '');
  set('age', line?.age === null || !line ? '-' : ms(Math.min(line.age, 99), 0), line?.age > 0.03 ? 'bad' : '');
  set('late', line ? `late ${fixed(100 * line.late_share, 1)} %` : '', line?.late_share > 0.01 ? 'warn' : '');
  set('rate', status?.rate && !lost ? `${Math.round(status.rate)} Hz` : '-', status?.rate < 900 ? 'warn' : '');
  set('missed', status && !lost ? `${status.missed} ticks late` : '');
  set('scene', latest.health?.scene?.name || hello?.scene || '-');
  set('source', hello ? `${latest.health?.scene?.model?.kind || hello.model}, ${hello.simulated ? 'simulated' : 'real'}` : '');
  const isReplay = hello?.badge === 'REPLAY';
  set('role', isReplay ? 'replay' : line?.role || '-', line?.role === 'observer' ? 'warn' : '');
  set(
    'device',
    line?.role === 'observer' && latest.health?.status?.operator_name
      ? `operated by ${latest.health.status.operator_name}`
      : hello
        ? `${hello.device.split(':')[0]}${status?.device?.fault ? `: ${status.device.fault}` : ''}`
        : '',
    status?.device?.fault ? 'bad' : '',
  );
  const own =
    pointer.delay !== null
      ? `, pointer delay ${Math.round(pointer.delay)} ms`
      : link.delay !== null
        ? `, page ${fixed(link.delay, 1)} ms`
        : '';
  set('page-delay', own);
  byId('badge').hidden = !hello || hello.badge === 'LIVE';
  write(byId('badge'), hello?.badge || '');
}

// Each frame updates the one slow drawing that has waited longest. Figures are updated in the other
// frames.
const figures = new Pace(66, 100);
const drawings = [[new Pace(33, 1000), () => view.draw()], [new Pace(66, 1000), () => charts.show()]];
let before = 0, healthAt = 0;
function frame(now) {
  requestAnimationFrame(frame);
  for (const pace of [figures, ...drawings.map(([own]) => own)]) pace.adapt(now - before);
  const wereFigures = figures.at === before;
  before = now;
  if (!wereFigures && figures.isDue(now)) return setup.isShown ? showSetup() : showFigures(now);
  if (setup.isShown) return;
  drawings.sort(([a], [b]) => a.at - b.at).find(([pace]) => pace.isDue(now))?.[1]();
}

function showSetup() {
  showState();
  setup.showAlarms(alarmsOf(latest));
  if (!setup.isFrozen) setup.draw();
}

function showFigures(now) {
  imagePanel.show(latest.status);
  view.showWords();
  if (!changed) return;
  changed = false;
  showState();
  showFacts();
  alarms.show(alarmsOf(latest), latest.status?.t);
  const missing = unconnected(latest.hello, latest.status, latest.lost);
  write(byId('unconnected'), missing.length ? `Not connected to ${missing.join('; ')}.` : '');
  if (latest.status) force.show(latest.status, mapping());
  if (latest.hello) scales.show(mapping(), latest.hello, latest.status?.waiting, latest.health?.scene?.capabilities);
  controls.showKinds(
    latest.health?.scene?.model?.kind || latest.hello?.model,
    latest.health?.scene?.capabilities?.degrees_of_freedom === 2,
  );
  if (latest.status) controls.showActs(latest.status);
  if (now - healthAt < 500 || byId('health').hidden) return;
  healthAt = now;
  showHealth(byId('set-up'), latest.hello, latest.health, latest.status);
}
requestAnimationFrame(frame);
