// Charts of the last ten seconds, drawn by uPlot if it was built in.
import { save } from './save.js';
import { figure, write } from './text.js';

const TIP_AT = 14;  // column of the measured tip
const SECONDS = 10, GAP_S = 0.15, ASK_AGAIN_MS = 1000, MIN_ZOOM_S = 0.05;
const STEP = 0.01, LEAP = 0.1;  // steps of the cursor by a key, relative to the width of a chart
const GRAM = 9.80665e-3;  // weight of one gram [N]
// Columns of a sample: number, t, scaled, sent, the device's x, y, z, age, round trip, longest
// tick, energy, the tip's x, y, z as commanded and as measured, drawn relative to the first
// position. The page adds score and misfit, which are unknown before it was opened. A series has a
// name, column, colour, dash and width; without a name it has no legend entry.
const STRIPS = [
  {
    title: 'Force',
    unit: 'N',
    series: [
      ['rendered', 2, '--series-a', [5, 3]],
      ['sent', 3, '--series-b'],
    ],
    factor: 1,
    zero: true,
    least: 0.1,
  },
  {
    title: 'Tip path',
    unit: 'mm',
    note: 'relative to the first position; thick: measured, thin: commanded',
    series: [
      ['x', 14, '--series-a'],
      ['y', 15, '--series-b', [5, 3]],
      ['z', 16, '--series-c', [2, 2]],
      ['', 11, '--series-a', undefined, 0.7],
      ['', 12, '--series-b', undefined, 0.7],
      ['', 13, '--series-c', undefined, 0.7],
    ],
    factor: 1e3,
    least: 0.5,
    fromFirst: true,
  },
  {
    title: 'Link',
    unit: 'ms',
    series: [
      ['age', 7, '--series-a'],
      ['round trip', 8, '--series-b', [5, 3]],
      ['tick', 9, '--series-c', [2, 2]],
    ],
    factor: 1e3,
    zero: true,
    least: 1,
  },
  {
    title: 'Device',
    unit: 'mm',
    series: [
      ['x', 4, '--series-a'],
      ['y', 5, '--series-b', [5, 3]],
      ['z', 6, '--series-c', [2, 2]],
    ],
    factor: 1e3,
    least: 0.5,
  },
  { title: 'Energy', unit: 'mJ', series: [['from the operator', 10, '--series-a']], factor: 1e3, zero: true, least: 0.1 },
  {
    title: 'Tracking',
    unit: 'score, σ',
    series: [
      ['score', 17, '--series-a'],
      ['misfit, σ', 18, '--series-b', [5, 3]],
    ],
    factor: 1,
    zero: true,
    least: 0.1,
  },
];

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export class Charts {
  constructor() {
    this.host = document.getElementById('strips');
    this.begin();
    this.frozen = null;  // samples that are shown while the charts pause
    this.plots = [];
    this.seen = [];  // the visible strips
    this.stale = [];  // visible strips that must be drawn again, the last one first
    this.zoom = null;  // visible times, [from, to]; null: the last ten seconds
    this.events = [];
  }
  // Loads uPlot. Without it the strips show a message.
  async load(isBuiltIn) {
    if (!isBuiltIn) {
      this.host.innerHTML = '<p class="empty">Built without charts. With npm: deploy/page.sh, then build again.</p>';
      return;
    }
    const sheet = document.createElement('link');
    sheet.rel = 'stylesheet';
    sheet.href = '/lib/uPlot.min.css';
    document.head.prepend(sheet);
    this.uPlot = (await import('/lib/uPlot.esm.js')).default;
    this.draw();
    new ResizeObserver(() => this.resize()).observe(this.host);
  }
  // Forgets all samples.
  begin() {
    this.samples = [];
    this.first = null;
    this.pastAskedAt = -Infinity;  // NaN: received
    this.zoom = null;
  }
  asksPast(now) {
    if (!(now - this.pastAskedAt > ASK_AGAIN_MS)) return false;
    this.pastAskedAt = now;
    return true;
  }
  takePast({ samples, run }) {
    if ((run ?? undefined) !== this.run) return;  // samples of another part of the recording
    const newer = this.samples.filter((sample) => sample.length > 2);
    this.samples = [];
    this.take(samples, this.run);
    this.take(newer, this.run);
    this.pastAskedAt = NaN;
  }
  // `run` changes when a replay jumps.
  take(samples, run) {
    if (run !== this.run) this.begin();
    this.run = run;
    let last = this.samples.length ? this.samples[this.samples.length - 1] : null;
    for (const sample of samples) {
      if (last && sample[0] <= last[0] && sample[1] >= last[1]) continue;
      if (last && sample[1] < last[1]) {
        if (sample[0] > 25 || last[0] - sample[0] < 100) continue;  // late samples, not a new session
        this.samples = [];
      }
      // Requests the past samples again.
      if (last && sample[0] - last[0] > 1 && Number.isNaN(this.pastAskedAt)) this.pastAskedAt = performance.now();
      // Inserts a gap.
      if (last && sample[1] - last[1] > GAP_S) this.samples.push([sample[0], (sample[1] + last[1]) / 2]);
      this.samples.push(sample);
      last = sample;
    }
    while (this.samples.length && this.samples[this.samples.length - 1][1] - this.samples[0][1] > SECONDS) this.samples.shift();
    this.changed = true;
  }
  draw() {
    this.plots.forEach((plot) => plot.destroy());
    this.stale = [];
    this.host.replaceChildren();
    this.plots = STRIPS.map((strip) => {
      const box = document.createElement('div');
      box.className = 'strip';
      box.innerHTML = '<h3></h3><p class="legend"></p><div class="plot"></div>';
      box.querySelector('h3').textContent = `${strip.title}, ${strip.unit}`;
      box.querySelector('.legend').replaceChildren(...strip.series.filter(([name]) => name).map(([name, , tone, dash]) => {
        const key = document.createElement('span');
        key.className = `key ${tone.slice(2)} ${name} ${dash ? (dash[0] > 3 ? 'dashed' : 'dotted') : ''}`;
        key.textContent = name;
        return key;
      }));
      box.querySelector('h3').title = strip.note || '';
      this.host.append(box);
      return new this.uPlot(this.options(strip, box), this.columns(strip), box.querySelector('.plot'));
    });
  }
  options(strip, box) {
    const axis = {
      stroke: colour('--dim'),
      grid: { stroke: colour('--grid'), width: 1 },
      ticks: { show: false },
      font: '11px system-ui, sans-serif',
    };
    return {
      width: Math.max(80, box.clientWidth),
      height: Math.max(60, box.clientHeight - 24),
      legend: { show: false },
      cursor: {
        y: false,
        points: { size: 6 },
        drag: { x: true, y: false, setScale: false },
        sync: { key: 'strips', setSeries: false },
        bind: { dblclick: () => () => this.zoomTo(null) },
      },
      padding: [6, 6, 0, 0],
      scales: {
        x: { time: false, range: (_, low, high) => this.zoom || [high - SECONDS, high] },
        y: { range: (_, low, high) => this.range(strip, low, high) },
      },
      axes: [
        {
          ...axis,
          size: 16,
          gap: 2,
          space: 60,
          label: 'time, s',
          labelSize: 13,
          labelGap: 0,
          labelFont: axis.font,
          splits: (u, i, low, high, step) => this.marksFrom(low, high, step),
          values: (u, marks) => marks.map((mark) => figure(Number((mark - this.end).toFixed(6)))),
        },
        { ...axis, space: 36, size: 36, label: strip.unit, labelSize: 13, labelGap: 0, labelFont: axis.font },
      ],
      series: [
        {},
        ...strip.series.map(([label, , tone, dash, width = 1.75]) => ({
          label,
          stroke: colour(tone),
          width,
          dash,
          points: { show: false },
        })),
      ],
      hooks: {
        setCursor: [({ cursor, data }) => this.showValues(strip, box, cursor.idx, data)],
        setSelect: [(plot) => this.select(plot)],
        draw: [(plot) => this.drawEvents(plot)],
        ready: [
          (plot) => plot.over.addEventListener('click', ({ offsetX }) => !this.hasSelected && this.onTime?.(plot.posToVal(offsetX, 'x'))),
        ],
      },
    };
  }
  // Shows the values at the cursor in the legend. While the charts pause, image and object follow
  // the cursor.
  showValues(strip, box, at, data) {
    const isInside = at !== null && at !== undefined;
    if (strip === STRIPS[0]) {
      const force = isInside ? data[2][at] : null;
      if (this.frozen && isInside) this.onCursor?.(data[0][at]);
      write(
        document.getElementById('charts-time'),
        Number.isFinite(force) ? `${(data[0][at] - this.end).toFixed(2)} s: ${figure(force)} N, ${figure(force / GRAM)} g` : '',
      );
    }
    const values = strip.series.map((_, i) => (isInside ? data[i + 1][at] : null));
    box
      .querySelectorAll('.key')
      .forEach((key, i) => write(key, strip.series[i][0] + (Number.isFinite(values[i]) ? ` ${figure(values[i])}` : '')));
  }
  // Returns the ticks of the time axis, whole steps before the newest time.
  marksFrom(low, high, step) {
    const first = Math.ceil((low - this.end) / step - 1e-9), count = Math.floor((high - this.end) / step + 1e-9) - first + 1;
    return Array.from({ length: Math.max(0, count) }, (_, i) => this.end + (first + i) * step);
  }
  // The newest visible time, from which the axis counts.
  get end() {
    return this.shown.length ? this.shown[this.shown.length - 1][1] : 0;
  }
  // A drag across one chart zooms all charts.
  select(plot) {
    const { left, width } = plot.select;
    this.hasSelected = width > 4;
    if (this.hasSelected) this.zoomTo([plot.posToVal(left, 'x'), plot.posToVal(left + width, 'x')]);
    if (width > 0) plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    setTimeout(() => { this.hasSelected = false; });
  }
  // Multiplies the visible time by `factor`; 0: the last ten seconds.
  zoomBy(factor) {
    if (!factor) return this.zoomTo(null);
    const [from, to] = this.zoom || [this.end - SECONDS, this.end],
      middle = (from + to) / 2,
      half = Math.max(MIN_ZOOM_S, Math.min(SECONDS, factor * (to - from))) / 2;
    this.zoomTo(2 * half >= SECONDS ? null : [middle - half, middle + half]);
  }
  // Zooms to the times `zoom`. The charts pause, so that these times stay visible.
  zoomTo(zoom) {
    if (zoom && !this.frozen) this.togglePause();
    else if (!zoom && this.zoom && this.frozen) this.togglePause();
    this.zoom = zoom;
    this.stale = [...this.seen];
    document.getElementById('charts-whole').hidden = !zoom;
    this.onZoom?.();
  }
  // Draws contact, flags and stops as lines with their names.
  takeEvents(events) {
    this.events = events;
  }
  drawEvents(plot) {
    const { ctx: pen, bbox } = plot, ratio = devicePixelRatio, { min, max } = plot.scales.x;
    pen.save();
    pen.font = `${10 * ratio}px system-ui, sans-serif`;
    pen.fillStyle = colour('--warn');
    let free = -Infinity;  // position from which the next name fits
    for (const { t, name } of this.events) {
      if (t < min || t > max) continue;
      const x = plot.valToPos(t, 'x', true);
      pen.fillRect(x, bbox.top, ratio, bbox.height);
      if (x < free || plot !== this.plots[0]) continue;
      pen.fillText(name, x + 3 * ratio, bbox.top + 10 * ratio);
      free = x + pen.measureText(name).width + 8 * ratio;
    }
    pen.restore();
  }
  range(strip, low, high) {
    if (low === null || high === null) return [0, 1];
    const bottom = strip.zero ? Math.min(0, low) : low,
      span = high - bottom,
      margin = span < strip.least ? strip.least - span / 2 : 0.08 * span;
    return [strip.zero ? bottom : bottom - margin, high + margin];
  }
  get shown() {
    return this.frozen || this.samples;
  }
  togglePause() {
    this.frozen = this.frozen ? null : [...this.samples];
    this.changed = true;
    if (!this.frozen) this.onCursor?.(null);
  }
  // The arrow keys move the time cursor of charts that pause.
  key({ key, shiftKey }) {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[key], plot = this.plots[this.seen[0]];
    if (!step || !plot) return false;
    if (!this.frozen) this.togglePause();
    this.onZoom?.();
    const width = plot.over.clientWidth, from = plot.cursor.left >= 0 ? plot.cursor.left : width;
    plot.setCursor({ left: Math.min(width - 1, Math.max(0, from + step * (shiftKey ? LEAP : STEP) * width)), top: 1 });
    return true;
  }
  columns(strip) {
    const t = this.shown.map((sample) => sample[1]);
    this.first ??= this.shown.find((sample) => Number.isFinite(sample[TIP_AT]));
    const from = (column) => (strip.fromFirst && this.first ? this.first[TIP_AT + ((column - TIP_AT + 3) % 3)] : 0);
    return [
      t,
      ...strip.series.map(([, column]) =>
        this.shown.map((sample) =>
          sample[column] === undefined || sample[column] === null ? null : (sample[column] - from(column)) * strip.factor,
        ),
      ),
    ];
  }
  // Draws one visible strip per call, the one that has waited longest.
  show() {
    if (this.changed && !this.frozen) this.stale = this.seen.filter((i) => !this.stale.includes(i)).concat(this.stale);
    this.changed = false;
    const next = this.stale.pop();
    if (next !== undefined) this.plots[next].setData(this.columns(STRIPS[next]));
  }
  toggleStrips() {
    this.host.classList.toggle('others');
    document.getElementById('strips-next').setAttribute('aria-pressed', String(this.host.classList.contains('others')));
    this.resize();
  }
  resize() {
    const boxes = this.host.querySelectorAll('.strip');
    this.seen = [...boxes.keys()].filter((i) => boxes[i].clientWidth > 0);
    this.stale = [...this.seen];
    this.plots.forEach((plot, i) =>
      plot.setSize({ width: Math.max(80, boxes[i].clientWidth), height: Math.max(60, boxes[i].clientHeight - 24) }),
    );
  }
  download() {
    const rows = [
      'number,t_s,scaled_N,sent_N,x_m,y_m,z_m,age_s,round_trip_s,longest_tick_s,energy_J,' +
        'commanded_x_m,commanded_y_m,commanded_z_m,tip_x_m,tip_y_m,tip_z_m,score,misfit_sigmas',
      ...this.shown.filter((sample) => sample.length > 2).map((sample) => sample.join(',')),
    ];
    save(new Blob([rows.join('\n') + '\n'], { type: 'text/csv' }), 'palpate-last-10-s.csv');
  }
}
