// The scales between device and tool and the force limit: active, requested and waiting values. The master applies a scale
// only while disengaged and without contact, and a limit only if it is lower.
import { figure, write } from './text.js';

// Time after which a slider at rest sends its value; time for which the chosen value is shown until
// the master confirms it.
const ASK_AFTER_MS = 200, HELD_MS = 1500;
const SLIDERS = [
  { key: 'position_scale', id: 'position-scale', unit: 'mm/mm', words: (scale) => `1 mm of the device is ${figure(scale)} mm of the tool` },
  { key: 'force_scale', id: 'force-scale', unit: 'N/N', words: (scale) => `1 N at the tool is ${figure(scale)} N on the device` },
];
const byId = (id) => document.getElementById(id);

// Returns the rotation matrix, row by row, of a unit quaternion w, x, y, z.
function rotationOf([w, x, y, z]) {
  return [
    1 - 2 * (y * y + z * z),
    2 * (x * y - w * z),
    2 * (x * z + w * y),
    2 * (x * y + w * z),
    1 - 2 * (x * x + z * z),
    2 * (y * z - w * x),
    2 * (x * z - w * y),
    2 * (y * z + w * x),
    1 - 2 * (x * x + y * y),
  ];
}
// Returns the active mapping from the master's status, else from the slave's scene, else from the
// first message (hello). Each may be missing.
export function mappingOf(status, scene, hello) {
  const now = scene?.operator, inForce = (key) => status?.[key] || now?.[key] || hello?.[key] || 1;
  const rotation = now?.orientation?.length === 4 ? rotationOf(now.orientation) : hello?.rotation || rotationOf([1, 0, 0, 0]);
  return { position_scale: inForce('position_scale'), force_scale: inForce('force_scale'), limit: inForce('force_limit'), rotation };
}

export class Scales {
  // `home` gets the focus after a mouse has moved a slider.
  constructor(link, home) {
    Object.assign(this, { link, home, own: {} });
    this.limit = byId('force-limit');
    byId('mapping').addEventListener('submit', (event) => this.lower(event));
    this.sliders = SLIDERS.map((one) => ({ ...one, input: byId(one.id), output: byId(`${one.id}-value`), chosenAt: -1e9 }));
    for (const slider of this.sliders) {
      slider.input.addEventListener('input', () => this.choose(slider));
      slider.input.addEventListener('change', () => slider.input.matches(':focus-visible') || this.home.focus());
    }
  }
  // The range is a tenth to ten times the value of the scene.
  choose(slider) {
    const scale = Number((this.own[slider.key] * 10 ** slider.input.valueAsNumber).toPrecision(3));
    slider.chosenAt = performance.now();
    this.write(slider, scale, true);
    clearTimeout(slider.timer);
    slider.timer = setTimeout(() => this.link.send({ do: 'set', [slider.key]: scale }), ASK_AFTER_MS);
  }
  lower(event) {
    event.preventDefault();
    const limit = this.limit.valueAsNumber;
    if (limit > 0) this.link.send({ do: 'set', force_limit: limit });
    this.limit.dataset.active = '';  // shows the active value again
    this.home.focus();
  }
  write({ input, output, unit, words }, scale, waits) {
    write(output, `${waits ? '… ' : ''}${figure(scale)} ${unit}`);
    const text = words(scale) + (waits ? '; waits until disengaged and without contact' : '');
    if (output.title !== text) output.title = text;
    if (input.getAttribute('aria-valuetext') !== text) input.setAttribute('aria-valuetext', text);
  }
  // `mapping`: active; `own`: of the scene; `waiting`: requested; `can`: the slave's limits, if
  // they are known.
  show(mapping, own, waiting, can) {
    this.own = own;
    for (const slider of this.sliders) {
      const most = can?.[`max_${slider.key}`];
      if (most > 0) slider.input.max = Math.min(1, Math.log10(most / own[slider.key])).toFixed(3);
      if (performance.now() - slider.chosenAt < HELD_MS || slider.input.matches(':active')) continue;
      const scale = waiting?.[slider.key] ?? mapping[slider.key], place = Math.log10(scale / own[slider.key]);
      if (Math.abs(slider.input.valueAsNumber - place) > 0.025) slider.input.value = place;
      this.write(slider, scale, Boolean(waiting?.[slider.key]));
    }
    const limit = String(Number(mapping.limit.toPrecision(3)));
    if (document.activeElement !== this.limit && this.limit.dataset.active !== limit) this.limit.value = this.limit.dataset.active = limit;
  }
}
