// Alarms of the master, each with the next step, and the event log.

import { minutes, write } from './text.js';

// Alarms that differ only in numbers are the same alarm.
const kindOf = ({ text }) => text.replace(/[\d.]+/g, '#');

// Returns a list of {level, text, next}. Without a connection to the master it has one alarm, which
// reports this.
export function alarmsOf({ status, lost }) {
  if (lost) {
    return [
      {
        level: 'bad',
        text: `The page has no connection to the master: ${lost}.`,
        next: 'The operator is disengaged. Check that palpate-master is running. The page reconnects by itself.',
      },
    ];
  }
  return status ? status.alarms : [{ level: 'idle', text: 'Waiting for the first tick.', next: '' }];
}

const MARK = { bad: '■', warn: '▲', idle: '●', ok: '✓' };
const LEVEL = { bad: 'Stop', warn: 'Note', idle: 'Wait', ok: 'Good' };

// Returns a list item with the message and the next step.
export function noteItem(level, text, next, isKnown = false) {
  const item = document.createElement('li'), head = document.createElement('b'), step = document.createElement('span');
  item.dataset.level = level;
  item.dataset.known = isKnown;
  head.textContent = `${MARK[level]} ${LEVEL[level]}${isKnown ? ', acknowledged' : ''}: ${text}`;
  step.textContent = next;
  item.append(head, step);
  return item;
}

export class AlarmPanel {
  constructor() {
    this.list = document.getElementById('alarm-list');
    this.log = document.getElementById('log');
    this.count = document.getElementById('alarm-count');
    this.shown = '';
    this.known = new Set();  // acknowledged alarms, until they end
    this.acts = document.getElementById('acknowledge');
    this.since = new Map();
  }
  // `t`: time of the session or the recording [s].
  show(alarms, t) {
    this.now = alarms.map(kindOf);
    this.known = new Set(this.now.filter((kind) => this.known.has(kind)));
    const news = alarms.filter((alarm) => alarm.level !== 'idle' && !this.known.has(kindOf(alarm))).length;
    write(this.count, news ? String(news) : '');
    this.acts.hidden = !news;
    if (!alarms.length) alarms = [{ level: 'ok', text: 'No alarm.', next: '' }];
    const key = JSON.stringify([alarms, [...this.known]]);
    if (key === this.shown) return;
    this.shown = key;
    this.since = new Map(alarms.map((alarm) => [kindOf(alarm), this.since.get(kindOf(alarm)) ?? t]));
    this.list.replaceChildren(...alarms.map(({ level, text, next }) => {
      const item = noteItem(level, text, next, this.known.has(kindOf({ text })));
      const since = this.since.get(kindOf({ text }));
      if (level !== 'ok' && Number.isFinite(since)) item.lastChild.textContent += `${next && ' '}Since ${minutes(since)}.`;
      return item;
    }));
  }
  // Present alarms stay in the list. An alarm counts again after it has ended and returned.
  acknowledge() {
    this.known = new Set(this.now);
  }
  showLog(entries) {
    this.log.replaceChildren(...entries.slice(-30).reverse().map(({ t, text, trouble }) => {
      const item = document.createElement('li');
      item.dataset.trouble = trouble;
      item.textContent = `${t.toFixed(1)} s  ${text}`;
      return item;
    }));
  }
}
