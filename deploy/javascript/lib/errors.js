'use strict';

const {status} = require('@grpc/grpc-js');

/** A call that the slave rejected, or a lost connection. `code` is the name of the gRPC status, `details` the sentence of the slave. */
class PalpateError extends Error {
  /** @param {string} code @param {string} details */
  constructor(code, details) {
    super(`${code}: ${details}`);
    this.code = code;
    this.details = details;
  }
}

/** Another client operates, or the operator was evicted. */
class LeaseHeld extends PalpateError {}

/** @param {{code: number, details: string}} error */
function translated(error, Kind = PalpateError) { return new Kind(status[error.code] || String(error.code), error.details); }

module.exports = {LeaseHeld, PalpateError, translated};
