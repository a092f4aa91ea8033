// Observes a slave, using only the .proto files: 100 states and a first mesh. Prints the number of
// skipped states, and the last forces of the fingertips if there are several. Exit code 0: the
// sequence increased throughout.
'use strict';

const {call, run} = require('./palpate_client');

const STATES = 100;

function words(finger) {
  const touch = finger.in_contact ? 'in contact' : 'free';
  const {x, y, z} = finger.force || {};
  const force = finger.force ? `${Math.hypot(x, y, z).toFixed(4)} N` : 'force unknown';
  return `${touch}, ${force}, ${finger.validity}`;
}

function firstOf(stream, count, look) {
  let seen = 0;
  return new Promise((resolve, reject) => {
    stream.on('data', (message) => {
      if (seen < count) look(message);
      if (++seen !== count) return;
      stream.cancel();
      resolve();
    });
    stream.on('error', (error) => seen < count ? reject(error) : undefined);
  });
}

async function main(client) {
  const status = await call(client, 'GetStatus', {});
  const wrong = [];
  const sensed = new Set();
  let first = 0, last = 0, nodes = 0, fingers = [];
  const deadline = Date.now() + 60000;
  await firstOf(client.WatchState({max_rate_hz: 100}, {deadline}), STATES, (state) => {
    first = first || state.sequence;
    if (state.sequence <= last) wrong.push(`sequence ${state.sequence} after ${last}`);
    last = state.sequence;
    fingers = state.fingers;
    sensed.add(`${state.sensed_at.seconds}.${state.sensed_at.nanos}`);
  });
  await firstOf(client.WatchMesh({}, {deadline}), 1, (mesh) => {
    nodes = mesh.positions.length / 3;
    if (mesh.positions.length !== mesh.rest.length || !mesh.elements.length) {
      wrong.push('the first mesh has no topology, or positions that do not fit it');
    }
  });
  fingers.forEach((finger, i) => {
    const {x, y, z} = finger.force || {x: 0, y: 0, z: 0};
    if (![x, y, z].every(Number.isFinite)) wrong.push(`the force of finger ${i + 1} is not a number`);
    console.log(`finger ${i + 1}: ${words(finger)}`);
  });
  console.log(`phase ${status.phase}: ${STATES} states, ${last - first + 1 - STATES} skipped, ` +
              `${sensed.size} samples, ${nodes} nodes`);
  return wrong;
}

run('watch.js HOST:PORT', main);
