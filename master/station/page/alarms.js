// What is wrong at this moment, in words, each with the next step; and what happened.
import { REASONS, norm } from './words.js';

const NEXT = {
  tracking_lost: 'Look at the picture: is the tool in it, is it covered? Lift it clear, then engage again.',
  extrapolated: 'Press less deep, or read CHECKS for the check that is named.',
  stale: 'See whether the camera or the fingertips still send: Setup names what they wait for.',
  punctured: 'Draw the tool back.',
  failed: "See the slave's log: it says why the model has no answer.",
};

// The alarms of a status: {level, text, next}.
export function alarmsOf({ status, health, lost, ended }) {
  const list = [];
  const add = (level, text, next) => list.push({ level, text, next });
  if (lost) {
    add('bad', `The page has no line to the master: ${lost}.`, 'The hand is let go. Is palpate-master still running in its terminal? The page comes back by itself.');
    return list;
  }
  if (!status) return [{ level: 'idle', text: 'Waiting for the first tick.', next: '' }];
  const { link, felt, chain } = status;
  if (status.state === 'ESTOP') add('bad', 'Emergency stop: the tool stands, the hand is let go.', 'When it is safe: R, or the button beside STOP, then engage again.');
  if (!link.connected) add('bad', `No line to the slave${link.trouble ? `: ${link.trouble}` : ''}.`, 'Is palpate-slave running? The master tries again by itself; engage again when it is back.');
  else if (link.trouble) add('warn', `The line to the slave: ${link.trouble}.`, 'If it stays, stop and start palpate-master.');
  else if (link.age > 0.03) add('bad', 'No state from the slave for more than 30 ms.', 'The tool stands. Wait, or look at the network.');
  if (felt && felt.validity !== 'valid') {
    const check = felt.check ? ` (check: ${felt.check.replaceAll('_', ' ')})` : '';
    add(['extrapolated', 'punctured'].includes(felt.validity) ? 'warn' : 'bad', `The force is ${felt.validity.replaceAll('_', ' ')}${check}.`, NEXT[felt.validity] || '');
  }
  for (const reason of chain.reasons) {
    if (['clamped', 'passivity', 'offset_jump', 'settings', 'bad_state', 'bad_device', 'aged'].includes(reason)) {
      add('warn', `The force was changed: ${REASONS[reason][1]}.`, reason === 'clamped' ? 'Press less: more cannot be felt.' : '');
    }
  }
  if (status.force_limit > 0 && norm(chain.sent) > 0.8 * status.force_limit && !chain.reasons.includes('clamped')) {
    add('warn', 'More than four fifths of the force limit.', 'Press no deeper.');
  }
  if (link.late_share > 0.01) add('warn', `States came late in ${(100 * link.late_share).toFixed(0)} % of the last 10 s.`, 'A slower line or a busy machine: see the charts.');
  for (const text of health?.status?.alarms || []) add('warn', `The slave says: ${text}.`, '');
  if (health?.trouble) add('warn', `The slave's health is not told: ${health.trouble}.`, '');
  return list;
}

const MARK = { bad: '■', warn: '▲', idle: '●', ok: '✓' };
const LEVEL = { bad: 'Stop', warn: 'Note', idle: 'Wait', ok: 'Good' };

export class AlarmPanel {
  constructor() {
    this.list = document.getElementById('alarm-list');
    this.said = document.getElementById('said');
    this.count = document.getElementById('alarm-count');
    this.shown = '';
    this.since = new Map();
  }
  show(alarms) {
    const bad = alarms.filter((alarm) => alarm.level !== 'idle').length;
    this.count.textContent = bad ? String(bad) : '';
    if (!alarms.length) alarms = [{ level: 'ok', text: 'Nothing is wrong.', next: '' }];
    const key = JSON.stringify(alarms);
    if (key === this.shown) return;
    this.shown = key;
    this.list.replaceChildren(...alarms.map(({ level, text, next }) => {
      const item = document.createElement('li');
      item.dataset.level = level;
      const head = document.createElement('b'), step = document.createElement('span');
      head.textContent = `${MARK[level]} ${LEVEL[level]}: ${text}`;
      step.textContent = next;
      item.append(head, step);
      return item;
    }));
  }
  showSaid(said) {
    this.said.replaceChildren(...said.slice(-30).reverse().map(({ t, text, trouble }) => {
      const item = document.createElement('li');
      item.dataset.trouble = trouble;
      item.textContent = `${t.toFixed(1)} s  ${text}`;
      return item;
    }));
  }
}
