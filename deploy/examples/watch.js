// Observes a slave: watch.js HOST:PORT [TLS_FOLDER]. Prints 100 states received, and how many were skipped. Exit code 0:
// the sequence increased throughout. The stubs are generated from the .proto files by @grpc/proto-loader.
'use strict';

const fs = require('fs');
const path = require('path');
const grpc = require('@grpc/grpc-js');
const loader = require('@grpc/proto-loader');

const STATES = 100;
const PROTO = path.join(__dirname, '../../proto');
// A cut link is silent, so the client pings after 1 s without data, and reports an error 10 s
// later.
const OPTIONS = {'grpc.enable_http_proxy': 0, 'grpc.keepalive_time_ms': 1000, 'grpc.keepalive_timeout_ms': 10000};

function connect(address, tls) {
  const definition = loader.loadSync('palpate/v1/teleoperation.proto',
                                     {includeDirs: [PROTO], keepCase: true, longs: Number, enums: String, defaults: true});
  const {Teleoperation} = grpc.loadPackageDefinition(definition).palpate.v1;
  const read = (name) => fs.readFileSync(path.join(tls, name));
  const credentials = tls ? grpc.credentials.createSsl(read('ca.pem'), read('key.pem'), read('cert.pem'))
                          : grpc.credentials.createInsecure();
  return new Teleoperation(address, credentials, OPTIONS);
}

async function main(address, tls) {
  const slave = connect(address, tls);
  const stream = slave.WatchState({max_rate: 100});
  stream.on('error', () => {});  // cancel() causes an error
  const states = [];
  for await (const state of stream) {
    if (states.push(state) === STATES) break;
  }
  stream.cancel();
  slave.close();
  const last = states[STATES - 1];
  const force = last.force ? `${Math.hypot(last.force.x, last.force.y, last.force.z).toFixed(4)} N` : 'force unknown';
  const steps = states.slice(1).map((state, i) => state.sequence - states[i].sequence);
  const skipped = steps.reduce((sum, step) => sum + step - 1, 0);
  console.log(`${STATES} states, ${skipped} skipped, the last: ${force}, ${last.validity.replace('VALIDITY_', '')}`);
  return steps.every((step) => step > 0) ? 0 : 1;
}

main(...process.argv.slice(2)).then((code) => process.exit(code), (error) => {
  console.error(`error: ${error.message}`);
  process.exit(1);
});
