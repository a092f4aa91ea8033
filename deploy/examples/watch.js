// Observes a slave: watch.js HOST:PORT [TLS_FOLDER]. 100 states, fingertips, and the deformed boundary. Prints the states
// received and skipped. Exit code 0: the sequence increased throughout.
'use strict';

const palpate = require('palpate');

const STATES = 100;

async function main(address, tls) {
  const slave = palpate.connect(address, {tls});
  const {phase} = await slave.status();
  const states = [];
  for await (const state of slave.states({rate: 100})) {
    if (states.push(state) === STATES) break;
  }
  let nodes = 0;
  for await (const mesh of slave.meshes()) {
    nodes = mesh.positions.length / 3;
    break;
  }
  slave.close();
  states[STATES - 1].message.fingers.forEach((finger, i) => {
    const touch = finger.in_contact ? 'in contact' : 'free';
    const force = finger.force ? `${Math.hypot(finger.force.x, finger.force.y, finger.force.z).toFixed(4)} N` : 'force unknown';
    console.log(`finger ${i + 1}: ${touch}, ${force}, ${finger.validity.replace('VALIDITY_', '')}`);
  });
  const steps = states.slice(1).map((state, i) => state.sequence - states[i].sequence);
  const skipped = steps.reduce((sum, step) => sum + step - 1, 0);
  console.log(`phase ${phase.replace('PHASE_', '')}: ${STATES} states, ${skipped} skipped, ` +
              `${new Set(states.map((state) => state.t)).size} samples, ${nodes} nodes`);
  return steps.every((step) => step > 0) && nodes > 0 ? 0 : 1;
}

main(...process.argv.slice(2)).then((code) => process.exit(code), (error) => {
  console.error(`error: ${error.message}`);
  process.exit(1);
});
