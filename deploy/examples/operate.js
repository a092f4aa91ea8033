// Operates a slave, using only the .proto files: engages, moves 6 mm + 3 mm down in 1.5 s, holds,
// retreats. Prints the peak force. Exit code 0: the force opposed the motion.
'use strict';

const {grpc, call, now, run} = require('./palpate_client');

const PERIOD = 4;                    // [ms] between commands
const APPROACH = 1500, HOLD = 500;   // [ms]
const DEPTH = 9e-3;                  // at the tool [m]

// Height of the device [m] at `t` [ms].
function height(t, depth) {
  const total = 2 * APPROACH + HOLD;
  return -depth * Math.min(1, t / APPROACH, Math.max(0, (total - t) / APPROACH));
}

function press(stream, depth) {
  const start = Date.now();
  let sequence = 0;
  const send = (y, engaged) => stream.write({
    sequence: ++sequence,
    sent_at: now(),
    epoch: 1,
    p_M: {x: 0, y, z: 0},
    velocity: {x: 0, y: 0, z: 0},
    engaged,
    operator_name: sequence === 1 ? 'operate.js' : '',
  });
  return new Promise((resolve) => {
    const timer = setInterval(() => {
      const t = Date.now() - start;
      if (t < 2 * APPROACH + HOLD) return send(height(t, depth), true);
      clearInterval(timer);
      send(0, false);
      setTimeout(() => {
        stream.end();
        resolve(sequence);
      }, 100);
    }, PERIOD);
  });
}

async function main(client) {
  const scene = await call(client, 'GetScene', {});
  const stream = client.Operate({deadline: Date.now() + 60000});
  const wrong = [];
  let count = 0, last = 0, peak = 0;
  stream.on('data', (state) => {
    ++count;
    if (state.sequence <= last) wrong.push(`sequence ${state.sequence} after ${last}`);
    last = state.sequence;
    const known = ['VALIDITY_VALID', 'VALIDITY_EXTRAPOLATED'].includes(state.validity);
    if (known && state.force && Math.abs(state.force.y) > Math.abs(peak)) peak = state.force.y;
  });
  stream.on('error', () => {});  // `status` reports it
  const ended = new Promise((resolve) => stream.on('status', resolve));
  const commands = await press(stream, DEPTH / scene.operator.position_scale);
  const status = await ended;
  if (status.code !== grpc.status.OK) wrong.push(`ended with ${status.code}: ${status.details}`);
  if (!(peak > 0)) wrong.push(`peak force ${peak} N along y does not oppose the motion`);
  console.log(`${scene.name}: ${count} states, ${commands} commands, peak force ${peak.toFixed(4)} N`);
  return wrong;
}

run('operate.js HOST:PORT', main);
