// Sends tactile samples to a slave: feed_tactile.js HOST:PORT. Every fingertip of the scene rests for half a second. A sample
// with 18 electrodes follows, which must be rejected with an explanation. Prints the number of accepted samples. Exit code 0: all.
'use strict';

const palpate = require('palpate');

const ELECTRODES = 19, SAMPLES = 50, RATE = 100;

async function* atRest(fingers) {
  const electrodes = Array.from({length: ELECTRODES}, (_, i) => 3000 + i);
  for await (const _ of palpate.paced(Array(SAMPLES).fill(0), RATE)) {
    yield* fingers.map((finger) => ({finger, electrodes, pressure: [2000, 1800]}));
  }
}

async function main(address) {
  const slave = palpate.connect(address);
  const scene = await slave.scene();
  const fingers = scene.fingertips.map((fingertip) => fingertip.name);
  const {samples} = await slave.feedFingertips(atRest(fingers));
  console.log(`${scene.name}: ${samples} samples of ${fingers.join(', ')} accepted`);
  const short = {finger: fingers[0], electrodes: Array(ELECTRODES - 1).fill(0)};
  const rejected = await slave.feedFingertips([short]).then(() => null, (error) => error);
  if (rejected) console.log(`18 electrodes: ${rejected.details}`);
  const explained = rejected && rejected.code === 'INVALID_ARGUMENT' && rejected.details.includes('accepted is');
  return samples === SAMPLES * fingers.length && explained ? 0 : 1;
}

main(...process.argv.slice(2)).then((code) => process.exit(code), (error) => {
  console.error(`error: ${error.message}`);
  process.exit(1);
});
