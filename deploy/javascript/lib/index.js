// Client of a Palpate slave:
//
//   const palpate = require('palpate');
//   const slave = palpate.connect('127.0.0.1:50051');
//   for await (const state of slave.states({rate: 10})) {
//     if (state.valid) console.log(state.force, '+-', state.sigma, 'N');
//   }
//
// Points and forces are arrays of three numbers in SI units, in the frame S of the slave. The messages have the names of the
// .proto files.
'use strict';

const fs = require('fs');
const path = require('path');
const grpc = require('@grpc/grpc-js');
const loader = require('@grpc/proto-loader');
const {LeaseHeld, PalpateError, translated} = require('./errors');
const {Operator} = require('./operator');
const {State, timestamp, vec3, vector} = require('./state');

/** @typedef {import('./state').Vector} Vector */
/** @typedef {import('../messages/palpate/v1/CameraPicture').CameraPicture} Picture */
/** @typedef {import('../messages/palpate/v1/MeshState').MeshState__Output} Mesh */
/** @typedef {import('../messages/palpate/v1/Teleoperation').TeleoperationClient} Client */
/** @typedef {import('../messages/teleoperation').ProtoGrpcType} ProtoGrpcType */
/**
 * An image, or the images of a stereo pair. `ms` since 1970: middle of the exposure, default now.
 * @typedef {{left: Picture, right?: Picture, ms?: number}} Image
 */
/**
 * Readings of one fingertip [counts]. `ms` since 1970, default now.
 * @typedef {{finger: string, electrodes: number[], pressure?: number[], ms?: number}} TactileSample
 */
/**
 * What a manipulator measures: tool tip [m], velocity [m/s], force of the object on the tool [N], fault as text.
 * @typedef {{tip: Vector, velocity?: Vector, force?: Vector, fault?: string}} ArmReading
 */
/**
 * A manipulator. `measure` gets the time since its last call [s].
 * @typedef {{measure(dt: number): ArmReading, go(tip: Vector, velocity: Vector): void, hold(): void}} Arm
 */

const PROTO = path.join(__dirname, '../proto');
const ANSWER = 10000;   // [ms] for the reply to a request
const SILENCE = 100;    // [ms] without a target, after which the arm holds on its own

/**
 * Connects to the slave at HOST:PORT: in plain text, or with ca.pem, cert.pem and key.pem of the folder `tls`.
 * @param {string} address @param {{tls?: string}} [options]
 */
function connect(address, {tls} = {}) {
  const definition = loader.loadSync('palpate/v1/teleoperation.proto',
                                     {includeDirs: [PROTO], keepCase: true, longs: Number, enums: String, defaults: true});
  const types = /** @type {ProtoGrpcType} */ (/** @type {unknown} */ (grpc.loadPackageDefinition(definition)));
  const read = (/** @type {string} */ name) => fs.readFileSync(path.join(tls || '', name));
  const credentials = tls ? grpc.credentials.createSsl(read('ca.pem'), read('key.pem'), read('cert.pem')) : grpc.credentials.createInsecure();
  return new Slave(new types.palpate.v1.Teleoperation(address, credentials, {'grpc.enable_http_proxy': 0}));
}

/** A connected slave. Every call rejects with a PalpateError if the slave rejects it or cannot be reached. */
class Slave {
  /** @param {Client} client */
  constructor(client) {
    /** All calls of palpate.v1, for what this class does not offer. */
    this.client = client;
  }

  close() { this.client.close(); }

  /** What is modelled: object, material, model, scales and limits. */
  scene() { return answer((done) => this.client.GetScene({}, deadline(), done)); }

  /** Phase, validity, operator, rates and alarms. */
  status() { return answer((done) => this.client.GetStatus({}, deadline(), done)); }

  /** Workspace, degrees of freedom, rates and limits. */
  capabilities() { return answer((done) => this.client.GetCapabilities({}, deadline(), done)); }

  /** Emergency stop, latched until `reset`. @param {string} [reason] */
  stop(reason = '') { return answer((done) => this.client.Stop({reason}, deadline(), done)); }

  /** Clears an emergency stop. Without one, tool, object and baseline are detected again. */
  reset() { return answer((done) => this.client.Reset({}, deadline(), done)); }

  /**
   * Yields the newest state, at most `rate` per second [Hz] (0: every new one), until the loop ends. Needs no lease and
   * cannot move the tool.
   * @param {{rate?: number, details?: boolean}} [options]
   * @returns {AsyncGenerator<State, void>}
   */
  async* states({rate = 0, details = false} = {}) {
    for await (const message of messages(this.client.WatchState({max_rate_hz: rate, details}))) yield new State(message);
  }

  /**
   * Yields the newest deformed boundary, at most `rate` per second [Hz] (0: 30).
   * @param {{rate?: number}} [options]
   * @returns {AsyncGenerator<Mesh, void>}
   */
  meshes({rate = 0} = {}) { return messages(this.client.WatchMesh({max_rate_hz: rate})); }

  /** Takes the lease under `name`. Rejects with LeaseHeld if another client has it. @param {string} name */
  async operate(name) {
    const operator = new Operator(this.client, await this.scene(), name);
    try {
      return await operator._begin();
    } catch (error) {
      const lost = error instanceof PalpateError && ['FAILED_PRECONDITION', 'ABORTED'].includes(error.code);
      throw lost ? new LeaseHeld(error.code, error.details) : error;
    }
  }

  /**
   * Sends images until `images` ends. The scene's camera needs `source: stream`. Resolves to how many were accepted.
   * @param {AsyncIterable<Image> | Iterable<Image>} images
   */
  async feedImages(images) {
    let sequence = 0;
    return feed((done) => this.client.FeedPictures(done), images,
                ({left, right, ms}) => ({sequence: ++sequence, sensed_at: timestamp(ms), picture: left, right: right || null}));
  }

  /**
   * Sends readings of fingertips until `samples` ends. Their `source` is `stream`. Resolves to how many were accepted.
   * @param {AsyncIterable<TactileSample> | Iterable<TactileSample>} samples
   */
  async feedFingertips(samples) {
    let sequence = 0;
    return feed((done) => this.client.FeedTactile(done), samples,
                ({ms, ...sample}) => ({...sample, sequence: ++sequence, sensed_at: timestamp(ms)}));
  }

  /**
   * Drives `arm` with `rate` reports per second [Hz] for `seconds`, or until the slave ends. The scene needs
   * `manipulator: {source: stream}`. Resolves to the numbers of reports and targets.
   * @param {Arm} arm @param {{rate?: number, seconds?: number, name?: string}} [options]
   */
  async drive(arm, {rate = 250, seconds = Infinity, name = ''} = {}) {
    const begin = performance.now();
    let reports = 0, targets = 0, target = 0, heard = begin, last = begin;
    const stream = this.client.DriveTool();
    const timer = setInterval(() => {
      const now = performance.now();
      if (now - begin > 1000 * seconds) {
        clearInterval(timer);
        stream.end();
        return;
      }
      if (now - heard > SILENCE) arm.hold();
      const {tip, velocity, force, fault} = arm.measure((now - last) / 1000);
      last = now;
      stream.write({sequence: ++reports, measured_at: timestamp(), p_S_tip: vec3(tip), velocity: velocity ? vec3(velocity) : null,
                    measured_force: force ? vec3(force) : null, fault: fault || '', target_sequence: target, driver_name: name, rate_hz: rate});
    }, 1000 / rate);
    try {
      for await (const message of messages(stream)) {
        ++targets;
        heard = performance.now();
        target = message.sequence;
        if (message.motion === 'MOTION_FOLLOW') arm.go(vector(message.p_S_tip), vector(message.velocity));
        else arm.hold();
      }
    } finally {
      clearInterval(timer);
      arm.hold();
    }
    return {reports, targets};
  }
}

/** Yields `items` at `rate` [Hz]. @template T @param {Iterable<T>} items @param {number} rate @returns {AsyncGenerator<T, void>} */
async function* paced(items, rate) {
  let due = performance.now();
  for (const item of items) {
    yield item;
    due = Math.max(due + 1000 / rate, performance.now());
    await new Promise((resolve) => setTimeout(resolve, due - performance.now()));
  }
}

const deadline = () => ({deadline: Date.now() + ANSWER});

/** @template T @param {(done: (error: grpc.ServiceError | null, reply?: T) => void) => unknown} call @returns {Promise<T>} */
function answer(call) {
  return new Promise((resolve, reject) => {
    call((error, reply) => error ? reject(translated(error)) : resolve(/** @type {T} */ (reply)));
  });
}

/**
 * @template T
 * @param {grpc.ClientReadableStream<T> | grpc.ClientDuplexStream<any, T>} stream
 * @returns {AsyncGenerator<T, void>}
 */
async function* messages(stream) {
  stream.on('error', () => {});  // also after the loop, where cancel makes one
  try {
    for await (const message of stream) yield message;
  } catch (error) {
    throw translated(/** @type {grpc.ServiceError} */ (error));
  } finally {
    stream.cancel();
  }
}

/**
 * @template Reply, Request, Item
 * @param {(done: (error: grpc.ServiceError | null, reply?: Reply) => void) => grpc.ClientWritableStream<Request>} open
 * @param {AsyncIterable<Item> | Iterable<Item>} items
 * @param {(item: Item) => Request} toMessage
 * @returns {Promise<Reply>}
 */
async function feed(open, items, toMessage) {
  let has_ended = false;
  /** @type {grpc.ClientWritableStream<Request> | undefined} */
  let stream;
  const reply = answer((/** @type {(error: grpc.ServiceError | null, reply?: Reply) => void} */ done) => {
    stream = open((error, value) => {
      has_ended = true;
      done(error, value);
    });
  });
  reply.catch(() => {});  // awaited below
  const writing = /** @type {grpc.ClientWritableStream<Request>} */ (/** @type {unknown} */ (stream));
  for await (const item of items) {
    if (has_ended) break;  // the slave rejected a sample: the reply says why
    if (!writing.write(toMessage(item))) {
      await Promise.race([new Promise((resolve) => writing.once('drain', () => resolve(null))), reply.catch(() => {})]);
    }
  }
  writing.end();
  return reply;
}

module.exports = {LeaseHeld, Operator, PalpateError, Slave, State, connect, paced};
