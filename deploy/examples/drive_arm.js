// Drives the slave's manipulator: drive_arm.js HOST:PORT [SECONDS] [X,Y,Z]. In place of a real arm it moves a point, which
// follows its target with a lag. X,Y,Z: where it starts [m], default the middle of the workspace. The scene needs
// `manipulator: {source: stream}`. Prints the number of reports and targets. Exit code 0: both were exchanged.
'use strict';

const palpate = require('palpate');

class LaggingPoint {
  constructor(home) {
    this.tip = home;
    this.target = home;
  }

  measure(dt) {
    const share = 1 - Math.exp(-dt / 0.003);  // time constant 3 ms
    this.tip = this.tip.map((x, i) => x + share * (this.target[i] - x));
    return {tip: this.tip};
  }

  go(tip) { this.target = tip; }

  hold() { this.target = this.tip; }
}

async function main(address, seconds = '1', place = '') {
  const slave = palpate.connect(address);
  const {workspace_min: low, workspace_max: high} = await slave.capabilities();
  const home = place ? place.split(',').map(Number) : ['x', 'y', 'z'].map((axis) => (low[axis] + high[axis]) / 2);
  const done = await slave.drive(new LaggingPoint(home), {seconds: Number(seconds), name: 'point'});
  console.log(`${done.reports} reports, ${done.targets} targets`);
  return done.reports > 0 && done.targets > 0 ? 0 : 1;
}

main(...process.argv.slice(2)).then((code) => process.exit(code), (error) => {
  console.error(`error: ${error.message}`);
  process.exit(1);
});
