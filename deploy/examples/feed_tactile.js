// Sends tactile samples to a slave, using only the .proto files: every fingertip of the scene rests
// for half a second. Prints the number of accepted samples. Exit code 0: all were accepted, and a
// sample with 18 electrodes was rejected with an explanation.
'use strict';

const {grpc, call, now, run} = require('./palpate_client');

const ELECTRODES = 19, SAMPLES = 50, PERIOD = 10;  // [ms]

function sample(sequence, finger, count = ELECTRODES) {
  return {
    sequence, finger, sensed_at: now(),
    electrodes: Array.from({length: count}, (_, i) => 3000 + i), pressure: [2000, 1800],
  };
}

// Opens a stream that `write` fills. Resolves to {error, reply} at its end.
function feed(client, write) {
  return new Promise((resolve) => {
    const stream = client.FeedTactile({deadline: Date.now() + 20000},
                                      (error, reply) => resolve({error, reply}));
    write(stream);
  });
}

async function main(client) {
  const scene = await call(client, 'GetScene', {});
  const fingers = scene.fingertips.map((fingertip) => fingertip.name);
  const {error, reply} = await feed(client, (stream) => {
    let sequence = 0;
    const timer = setInterval(() => {
      ++sequence;
      fingers.forEach((finger) => stream.write(sample(sequence, finger)));
      if (sequence < SAMPLES) return;
      clearInterval(timer);
      stream.end();
    }, PERIOD);
  });
  const wrong = [];
  if (error) {
    wrong.push(error.message);
  } else {
    console.log(`${scene.name}: ${reply.samples} samples of ${fingers.join(', ')} accepted`);
    if (reply.samples !== SAMPLES * fingers.length) wrong.push('not all samples were accepted');
  }
  const refused = await feed(client, (stream) => stream.end(sample(1, fingers[0], ELECTRODES - 1)));
  if (!refused.error || refused.error.code !== grpc.status.INVALID_ARGUMENT ||
      !refused.error.details.includes('accepted is')) {
    wrong.push('18 electrodes were not rejected with an explanation');
  }
  return wrong;
}

run('feed_tactile.js HOST:PORT', main);
