// Loads palpate.v1 from the .proto files and opens a client to HOST:PORT.
'use strict';

const path = require('path');
const grpc = require('@grpc/grpc-js');
const loader = require('@grpc/proto-loader');

const PROTO = path.resolve(__dirname, '..', '..', 'proto');

function connect(target) {
  const definition = loader.loadSync('palpate/v1/teleoperation.proto', {
    includeDirs: [PROTO],
    keepCase: true,
    longs: Number,
    enums: String,
    defaults: true,
  });
  const {Teleoperation} = grpc.loadPackageDefinition(definition).palpate.v1;
  return new Teleoperation(target, grpc.credentials.createInsecure(),
                           {'grpc.enable_http_proxy': 0});
}

// A unary call as a promise, with a deadline of 10 s.
function call(client, method, request) {
  return new Promise((resolve, reject) => {
    client[method](request, {deadline: Date.now() + 10000},
                   (error, reply) => error ? reject(error) : resolve(reply));
  });
}

function now() {
  const ms = Date.now();
  return {seconds: Math.floor(ms / 1000), nanos: (ms % 1000) * 1e6};
}

// Runs `main` and prints its errors. Exit code 0: none, 1: errors, 2: unusable arguments.
function run(usage, main) {
  if (!process.argv[2]) {
    console.error(`usage: ${usage}`);
    process.exit(2);
  }
  main(connect(process.argv[2])).then(
      (wrong) => {
        wrong.forEach((problem) => console.log(`error: ${problem}`));
        process.exit(wrong.length ? 1 : 0);
      },
      (error) => {
        console.error(error.message);
        process.exit(1);
      });
}

module.exports = {grpc, call, now, run};
