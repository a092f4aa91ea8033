// What the slave's errors become on the wire: a status code and the same sentence.
#pragma once

#include <exception>
#include <stdexcept>

#include <grpcpp/support/status.h>

namespace palpate {

// How every stream ends when the slave stops.
inline grpc::Status Stopping() {
  return {grpc::StatusCode::UNAVAILABLE, "the slave is stopping"};
}

// Runs `work`. std::invalid_argument: INVALID_ARGUMENT; another std::logic_error (not now):
// FAILED_PRECONDITION; anything else: INTERNAL.
template <class Work>
grpc::Status Guarded(const Work& work) {
  try {
    work();
    return grpc::Status::OK;
  } catch (const std::invalid_argument& error) {
    return {grpc::StatusCode::INVALID_ARGUMENT, error.what()};
  } catch (const std::logic_error& error) {
    return {grpc::StatusCode::FAILED_PRECONDITION, error.what()};
  } catch (const std::exception& error) {
    return {grpc::StatusCode::INTERNAL, error.what()};
  }
}

}  // namespace palpate
