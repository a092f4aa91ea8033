// Sends thirty uncompressed grey images of 64 x 48 px to a slave, using only the .proto files. Prints the number of
// accepted images. Exit code 0: all were accepted, and half an image was rejected with an explanation.
'use strict';

const {grpc, now, run} = require('./palpate_client');

const WIDTH = 64, HEIGHT = 48, PICTURES = 30, PERIOD = 33;  // [px], [ms]

function sample(sequence, bytes = WIDTH * HEIGHT) {
  const data = Buffer.from(Array.from({length: bytes}, (_, i) => (sequence + i) % 256));
  return {
    sequence, sensed_at: now(),
    picture: {encoding: 'ENCODING_GREY8', width: WIDTH, height: HEIGHT, data},
  };
}

// Opens a stream that `write` fills. Resolves to {error, reply} at its end.
function feed(client, write) {
  return new Promise((resolve) => {
    const stream = client.FeedPictures({deadline: Date.now() + 20000},
                                       (error, reply) => resolve({error, reply}));
    write(stream);
  });
}

async function main(client) {
  const {error, reply} = await feed(client, (stream) => {
    let sequence = 0;
    const timer = setInterval(() => {
      stream.write(sample(++sequence));
      if (sequence < PICTURES) return;
      clearInterval(timer);
      stream.end();
    }, PERIOD);
  });
  const wrong = [];
  if (error) {
    wrong.push(error.message);
  } else {
    console.log(`${reply.samples} images accepted`);
    if (reply.samples !== PICTURES) wrong.push('not all images were accepted');
  }
  const half = await feed(client, (stream) => stream.end(sample(1, WIDTH * HEIGHT / 2)));
  if (!half.error || half.error.code !== grpc.status.INVALID_ARGUMENT ||
      !half.error.details.includes('accepted is')) {
    wrong.push('half an image was not rejected with an explanation');
  }
  return wrong;
}

run('feed_pictures.js HOST:PORT', main);
