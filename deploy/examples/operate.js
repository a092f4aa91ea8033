// Operates a slave: operate.js HOST:PORT [TLS_FOLDER]. Moves the tool 9 mm down along y, in the silicone block 6 mm of air
// and 3 mm of indentation, holds and retreats. Prints the peak force. Exit code 0: the force opposed the motion.
'use strict';

const palpate = require('palpate');

const DOWN = 9e-3, SPEED = 6e-3;  // [m], [m/s]

async function main(address, tls) {
  const slave = palpate.connect(address, {tls});
  const tool = await slave.operate('operate.js');
  const states = [...await tool.moveBy([0, -DOWN, 0], SPEED), ...await tool.hold(0.5)];
  await tool.moveBy([0, DOWN, 0], SPEED);
  await tool.close();
  const {name} = await slave.scene();
  const peak = Math.max(...states.filter((state) => state.known).map((state) => state.force[1]));
  console.log(`${name}: ${states.length} states, peak force ${peak.toFixed(4)} N`);
  return peak > 0 ? 0 : 1;
}

main(...process.argv.slice(2)).then((code) => process.exit(code), (error) => {
  console.error(`error: ${error.message}`);
  process.exit(1);
});
