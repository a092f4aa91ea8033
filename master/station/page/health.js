// What is set up: the scene with its numbers, the slave's times, this session.
import { noteItem } from './alarms.js';
import { TRACE, figure, ms, stressUnit } from './words.js';

const stress = (pascal) => `${figure(pascal * stressUnit(pascal).factor)} ${stressUnit(pascal).unit}`;

const MOST_REJECTED = 3;
const spanOf = ({ workspace_min: low, workspace_max: high }) => ['x', 'y', 'z'].map((axis) => `${figure(1e3 * (low?.[axis] ?? 0))} to ${figure(1e3 * (high?.[axis] ?? 0))}`).join(', ') + ' mm';

// How long the station's certificate holds, and what to do in time.
function certificateOf(until) {
  const days = Math.floor((until * 1e3 - Date.now()) / 864e5);
  return `${new Date(until * 1e3).toISOString().slice(0, 10)}, ${days < 0 ? 'over: issue it anew (deploy/certs)' : `in ${days} days${days < 7 ? ': issue it anew (deploy/certs)' : ''}`}`;
}

// Names and values in groups: [[group, [[name, value], ...]], ...].
function groupsOf(hello, health, status) {
  const scene = health?.scene, can = health?.capabilities, slave = health?.status, groups = [];
  if (hello) {
    groups.push(['Session', [hello.badge === 'REPLAY' ? ['recording', hello.target] : ['slave at', `${hello.target}, ${hello.encrypted ? 'TLS' : 'plain text'}`], ...(hello.badge === 'REPLAY' ? [] : [['role', status?.link.role || 'not known']]), ['device', hello.device], ['rendering', hello.render],
      [hello.badge === 'REPLAY' ? 'recorded by palpate-master' : 'palpate-master', hello.version], ['clock offset', status ? ms(status.link.clock_offset, 3) : '-'], ['from the picture to the hand', ms(status?.link.sensed_age ?? NaN, 0)], ['reconnects', status?.link.reconnects ?? '-'],
      ['states refused', status?.link.refused ?? '-'], ...(hello.certificate_until ? [['certificate holds until', certificateOf(hello.certificate_until)]] : [])]]);
  }
  if (status?.trace) {
    const { trace } = status;
    groups.push(['From light or touch to the hand', [['sample, state', `${trace.sample}, ${trace.state}`], ['tick at', `${trace.t.toFixed(3)} s`], ...TRACE.map(([key, name]) => [name, ms(trace[key], 2)]), ['together', ms(trace.total, 2)]]]);
  }
  if (scene) {
    const material = scene.material || {}, model = scene.model || {};
    groups.push(['Object', [['shape', scene.geometry], ["Young's modulus", stress(material.young_modulus)], ["Poisson's ratio", figure(material.poisson_ratio)],
      ['density', material.density ? `${figure(material.density)} kg/m³` : 'not given']]]);
    groups.push(['Model', [['kind', model.kind], ['why', model.reason], ['unknowns, elements', `${model.dof}, ${model.elements}`], ['contact', model.contact || '-'],
      ...(model.plane ? [['plane', model.plane]] : []), ...(model.range ? [['made for', `displacements up to ${figure(100 * model.range)} % of the larger side`]] : []),
      ...(model.error ? [['expected error of the force', `${figure(100 * model.error)} %`]] : []), ...(model.rejected || []).slice(0, MOST_REJECTED).map(({ model: other, why }) => [`not ${other}`, why])]]);
    const own = scene.operator || {};
    groups.push(['Hand to tool', [['motion', `${figure(own.position_scale)} mm/mm`], ['force', `${figure(own.force_scale)} N/N`], ['limit at the hand', `${figure(own.force_limit)} N`],
      ['silence that counts as lost', ms(own.dead_after, 0)], ['settings, revision', scene.settings_revision]]]);
    groups.push(['Sense', [['source', scene.source], ...(scene.fingertips || []).map((tip) => [`finger ${tip.name}`, tip.network || 'no network: its force stays unknown'])]]);
  }
  if (can) groups.push(['Limits', [['sensor rate', `${figure(can.sensor_rate)} Hz`], ['fastest tool', `${figure(can.max_speed * 1e3)} mm/s`], ['workspace x, y, z', spanOf(can)], ['largest scales, motion and force', `${figure(can.max_position_scale)}, ${figure(can.max_force_scale)}`], ['palpate-slave', can.version]]]);
  if (slave) {
    groups.push(['Slave', [['phase', (slave.phase || '').replace('PHASE_', '').toLowerCase()], ['operator', slave.operator_name || 'without a name'], ['observers', slave.observers],
      ['samples a second', figure(slave.frame_rate)], ...(slave.stages || []).map((stage) => [`${stage.stage}: median, 99 % below`, `${figure(stage.p50_us / 1e3)}, ${figure(stage.p99_us / 1e3)} ms`])]]);
  }
  return groups;
}

// What the doctor found, the bad first.
export function showFindings({ done, findings }) {
  const bad = findings.filter(({ level }) => level === 'bad').length;
  document.getElementById('examine').disabled = !done;
  document.getElementById('examined').textContent = !done ? 'measuring, a few seconds ...' : bad ? `${bad} will be felt, or keep it from working` : 'fit to feel';
  document.getElementById('findings').replaceChildren(...findings.map(({ level, what, measured, advice }) => noteItem(level, `${what}: ${measured}`, advice)));
}

export function showHealth(panel, hello, health, status) {
  panel.replaceChildren(...groupsOf(hello, health, status).map(([name, rows]) => {
    const group = document.createElement('section'), title = document.createElement('h3'), list = document.createElement('dl');
    title.textContent = name;
    list.replaceChildren(...rows.map(([key, value]) => {
      const row = document.createElement('div'), dt = document.createElement('dt'), dd = document.createElement('dd');
      dt.textContent = key;
      dd.textContent = String(value ?? '-');
      row.append(dt, dd);
      return row;
    }));
    group.append(title, list);
    return group;
  }));
}
