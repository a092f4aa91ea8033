// Sends thirty grey images to a slave: feed_pictures.js HOST:PORT [WxH], default 64x48. A damaged image follows, which must be
// rejected with an explanation. The scene needs a camera with `source: stream`. Prints the number of accepted images. Exit code 0: all.
'use strict';

const palpate = require('palpate');

const IMAGES = 30, RATE = 30;

function grey(level, width, height) {
  const data = Buffer.from(Array.from({length: width * height}, (_, i) => (level + i) % 256));
  return {left: {encoding: 'ENCODING_GREY8', width, height, data}};
}

async function main(address, size = '64x48') {
  const slave = palpate.connect(address);
  const images = Array.from({length: IMAGES}, (_, level) => grey(level, ...size.split('x').map(Number)));
  const reply = await slave.feedImages(palpate.paced(images, RATE));
  console.log(`${reply.samples} of ${IMAGES} images accepted`);
  const damaged = {left: {encoding: 'ENCODING_PNG', data: Buffer.from('no image')}};
  const rejected = await slave.feedImages([damaged]).then(() => null, (error) => error);
  if (rejected) console.log(`a damaged image: ${rejected.details}`);
  const explained = rejected && rejected.code === 'INVALID_ARGUMENT' && rejected.details.includes('accepted is');
  return reply.samples === IMAGES && explained ? 0 : 1;
}

main(...process.argv.slice(2)).then((code) => process.exit(code), (error) => {
  console.error(`error: ${error.message}`);
  process.exit(1);
});
