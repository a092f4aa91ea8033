// The Setup panel: values of the scene, times of the slave, this session.
import { noteItem } from './alarms.js';
import { TRACE, figure, ms, stressUnit } from './text.js';

const stress = (pascal) => `${figure(pascal * stressUnit(pascal).factor)} ${stressUnit(pascal).unit}`;

const MAX_REJECTED = 3;
const spanOf = ({ workspace_min: low, workspace_max: high }) =>
  ['x', 'y', 'z'].map((axis) => `${figure(1e3 * (low?.[axis] ?? 0))} to ${figure(1e3 * (high?.[axis] ?? 0))}`).join(', ') + ' mm';

// Returns the expiry of the station's certificate, and what to do.
function certificateOf(until) {
  const days = Math.floor((until * 1e3 - Date.now()) / 864e5);
  return `${new Date(until * 1e3).toISOString().slice(0, 10)}, ` +
    `${days < 0 ? 'expired: issue a new one (deploy/certs)' : `in ${days} days${days < 7 ? ': issue a new one (deploy/certs)' : ''}`}`;
}

// Returns names and values in groups: [[group, [[name, value], ...]], ...].
function groupsOf(hello, health, status) {
  const scene = health?.scene, can = health?.scene?.capabilities, slave = health?.status, groups = [];
  if (hello) {
    groups.push([
      'Session',
      [
        hello.badge === 'REPLAY' ? ['recording', hello.target] : ['slave at', `${hello.target}, ${hello.encrypted ? 'TLS' : 'plain text'}`],
        ...(hello.badge === 'REPLAY' ? [] : [['role', status?.link.role || 'unknown']]),
        ['device', hello.device],
        ['rendering', hello.render],
        [hello.badge === 'REPLAY' ? 'recorded by palpate-master' : 'palpate-master', hello.version],
        ['clock offset', status ? ms(status.link.clock_offset, 3) : '-'],
        ['age of the sample', ms(status?.link.sensed_age ?? NaN, 0)],
        ['reconnects', status?.link.reconnects ?? '-'],
        ['states rejected', status?.link.refused ?? '-'],
        ...(hello.certificate_until ? [['certificate valid until', certificateOf(hello.certificate_until)]] : []),
      ],
    ]);
  }
  if (status?.device) {
    const { fault, calibration, output, temperature, force_share: share, buttons } = status.device;
    groups.push([
      'Device',
      [
        ['state', fault || 'good readings'],
        ['calibration', calibration],
        ['output', output],
        ...(share === null ? [] : [['renders', `${figure(100 * share)} % of the force`]]),
        ...(temperature === null ? [] : [['warmest motor', `${figure(100 * temperature)} % of its limit`]]),
        ['buttons pressed', buttons.join(', ') || 'none'],
      ],
    ]);
  }
  if (status?.trace) {
    const { trace } = status;
    groups.push([
      'End-to-end latency',
      [
        ['sample, state', `${trace.sample}, ${trace.state}`],
        ['tick at', `${trace.t.toFixed(3)} s`],
        ...TRACE.map(([key, name]) => [name, ms(trace[key], 2)]),
        ['total', ms(trace.total, 2)],
      ],
    ]);
  }
  if (scene) {
    const material = scene.material || {}, model = scene.model || {};
    groups.push([
      'Object',
      [
        ['shape', scene.geometry],
        ["Young's modulus", stress(material.young_modulus)],
        ["Poisson's ratio", figure(material.poisson_ratio)],
        ['density', material.density ? `${figure(material.density)} kg/m³` : 'not given'],
      ],
    ]);
    groups.push([
      'Model',
      [
        ['kind', model.kind],
        ['why', model.reason],
        ['unknowns, elements', `${model.dof}, ${model.elements}`],
        ['contact', model.contact || '-'],
        ...(model.plane ? [['plane', model.plane]] : []),
        ...(model.range ? [['range', `displacements up to ${figure(100 * model.range)} % of the larger side`]] : []),
        ...(model.error ? [['expected error of the force', `${figure(100 * model.error)} %`]] : []),
        ...(model.rejected || []).slice(0, MAX_REJECTED).map(({ model: other, why }) => [`not ${other}`, why]),
      ],
    ]);
    const own = scene.operator || {};
    groups.push([
      'Device to tool',
      [
        ['position scale', `${figure(own.position_scale)} mm/mm`],
        ['force scale', `${figure(own.force_scale)} N/N`],
        ['force limit on the device', `${figure(own.force_limit)} N`],
        ['link timeout', ms(own.dead_after, 0)],
        ['settings, revision', scene.settings_revision],
      ],
    ]);
    groups.push([
      'Sensing',
      [
        ['source', scene.source],
        ...(scene.fingertips || []).map((tip) => [`finger ${tip.name}`, tip.network || 'no neural network: its force is unknown']),
      ],
    ]);
  }
  if (can)
    groups.push([
      'Limits',
      [
        ['sensor rate', `${figure(can.sensor_rate)} Hz`],
        ['largest tool speed', `${figure(can.max_speed * 1e3)} mm/s`],
        ['workspace x, y, z', spanOf(can)],
        ['largest position and force scale', `${figure(can.max_position_scale)}, ${figure(can.max_force_scale)}`],
        ['palpate-slave', can.version],
      ],
    ]);
  if (slave) {
    groups.push([
      'Slave',
      [
        ['phase', (slave.phase || '').replace('PHASE_', '').toLowerCase()],
        ['operator', slave.operator_name || 'unnamed'],
        ['observers', slave.observers],
        ['samples per second', figure(slave.sample_rate)],
        ...(slave.stages || []).map((stage) => [
          `${stage.stage}: median, 99 % below`,
          `${figure(stage.p50_us / 1e3)}, ${figure(stage.p99_us / 1e3)} ms`,
        ]),
      ],
    ]);
  }
  return groups;
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
