// The force on the device, and each step from the estimate to it.
import { REASONS, TRACE, VALIDITY, codeOf, figure, fixed, ms, norm, write, xyz } from './text.js';

const STATIONS = [
  ['estimated', 'estimated'],
  ['local', 'local model'],
  ['scaled', 'scaled'],
  ['passive', 'passive'],
  ['limited', 'limited'],
  ['sent', 'sent'],
];
const HOLD_S = 3;  // time for which the peak is shown
const GRAM = 9.80665e-3;  // weight of one gram [N]

const byId = (id) => document.getElementById(id);

// Without a manipulator nothing is rendered; then the page shows the force of the object on the
// tool, frame S. NaN: it is unknown.
const observedForce = ({ link, slave_state: state }) => (link.observes && state?.force ? xyz(state.force) : null);
const shownForce = (status) => observedForce(status) || (status.link.observes ? [NaN, NaN, NaN] : status.chain.sent);

export class ForcePanel {
  constructor() {
    this.peak = 0;
    this.peakAt = -1e9;
    this.rows = STATIONS.map(([key, name]) => {
      const row = document.createElement('tr');
      row.dataset.station = key;
      row.innerHTML = '<th scope="row"></th><td class="value"></td><td class="why"><i></i><span></span></td>';
      row.querySelector('th').textContent = name;
      byId('chain').tBodies[0].append(row);
      return { key, value: row.querySelector('.value'), bar: row.querySelector('i'), why: row.querySelector('span'), row };
    });
    this.meter = byId('meter');
  }
  show(status, scales) {
    const observed = observedForce(status), chain = observed ? { ...status.chain, estimated: observed } : status.chain;
    write(byId('force-title').firstChild, status.link.observes ? 'Force of the object on the tool ' : 'Force on the device ');
    const sent = norm(shownForce(status)), limit = status.force_limit || 1, full = 1.1 * limit;
    this.holdPeak(status, sent);
    write(byId('magnitude'), fixed(sent));
    write(byId('peak'), fixed(this.peak));
    write(byId('grams'), Number.isFinite(sent) ? `${figure(sent / GRAM)} g` : '');
    this.showMeter(status, sent, limit, full, scales);
    for (const row of this.rows) this.showStation(row, chain, full, scales);
    const [x, y, z] = shownForce(status);
    write(
      byId('components'),
      `${observed ? 'frame S' : 'sent, device frame'}: x ${fixed(x)}  y ${fixed(y)}  z ${fixed(z)} ` +
      `N${norm(status.tare) > 0 ? `; tare ${figure(norm(status.tare))} N` : ''}`,
    );
    const { trace } = status;
    write(
      byId('trace'),
      trace
        ? `end-to-end latency ${ms(trace.total, 0)}: ${TRACE.map(([key, , short]) => `${short} ${fixed(1e3 * trace[key], 1)}`).join(', ')}`
        : '',
    );
    this.showValidity(status.slave_state);
    this.showFingers(status.fingers);
  }
  // Clears all values.
  forget() {
    this.peak = 0;
    for (const figure of [byId('magnitude'), byId('peak'), ...this.rows.map(({ value }) => value)]) write(figure, '-');
    for (const bar of [...this.meter.children, ...this.rows.map(({ bar }) => bar)]) bar.style.width = 0;
    for (const words of ['components', 'trace', 'meter-scale', 'grams']) write(byId(words), '');
    this.showValidity(null);
    this.showFingers([]);
  }
  holdPeak(status, sent) {
    const most = Math.max(sent || 0, ...status.samples.map((sample) => sample[3] || 0)), isElsewhere = this.run !== status.replay?.run;
    this.run = status.replay?.run;
    if (isElsewhere || most >= this.peak || status.t - this.peakAt > HOLD_S) {
      this.peak = most;
      this.peakAt = status.t;
    }
  }
  showMeter(status, sent, limit, full, scales) {
    const share = (value) => `${(100 * Math.min(1, Math.max(0, value / full))).toFixed(2)}%`;
    const set = (name, left, width) => {
      const bar = this.meter.querySelector(`.${name}`);
      bar.style.left = share(left);
      if (width !== undefined) bar.style.width = share(width);
    };
    set('warn', 0.8 * limit, 0.2 * limit);
    set('fill', 0, sent || 0);
    set('hold', this.peak);
    set('limit', limit);
    const scaled = norm(status.chain.scaled), sigma = (status.slave_state?.sigma || 0) * scales.force_scale;
    const known = status.chain.estimated !== null && sigma > 0 && scaled > 0;
    this.meter.querySelector('.sigma').hidden = !known;
    if (known) set('sigma', scaled - sigma, 2 * sigma);
    this.meter.setAttribute('aria-valuemax', fixed(limit));
    this.meter.setAttribute('aria-valuenow', fixed(sent || 0));
    this.meter.dataset.level = sent > 0.8 * limit ? 'warn' : 'ok';
    write(
      byId('meter-scale'),
      `warning from ${figure(0.8 * limit)}, limit ${figure(limit)} N${known ? `; one sigma ±${figure(sigma)} N` : ''}`,
    );
  }
  showStation({ key, value, bar, why, row }, chain, full, scales) {
    const force = norm(chain[key]), reasons = chain.reasons.filter((reason) => REASONS[reason]?.[0] === key);
    write(value, force === null || force === undefined ? 'unknown' : fixed(force, 3));
    // Forces before the scaling act on the tool; they are drawn at the scale of the device.
    const shown = (force || 0) * (key === 'estimated' || key === 'local' ? scales.force_scale : 1);
    bar.style.width = `${(100 * Math.min(1, shown / full)).toFixed(1)}%`;
    const words = reasons.map((reason) => REASONS[reason][1]).join('; ');
    if (row.title === words && row.dataset.changed) return;
    why.textContent = row.title = words;
    row.dataset.changed = reasons.length > 0;
  }
  showValidity(state) {
    const [level, words] = state ? VALIDITY[codeOf(state.validity, 'VALIDITY_')] : ['idle', 'not received yet'];
    const chip = byId('validity');
    chip.dataset.level = level;
    const check = codeOf(state?.check, 'FAILED_CHECK_');
    write(chip, words + (check === 'unspecified' ? '' : `: ${check.replaceAll('_', ' ')}`));
  }
  showFingers(fingers) {
    const list = byId('fingers');
    if (fingers.length < 2) return list.replaceChildren();
    list.replaceChildren(...fingers.map((finger) => {
      const item = document.createElement('li');
      const force = finger.force ? `${fixed(norm(finger.force), 3)} N` : 'unknown';
      item.textContent = `${finger.name}: ${finger.in_contact ? 'contact' : 'free'}, ${force}, ${VALIDITY[codeOf(finger.validity, 'VALIDITY_')][1]}`;
      return item;
    }));
  }
}
