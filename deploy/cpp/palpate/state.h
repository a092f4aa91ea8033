// A state of the slave, and what calls throw. SI units, frame S of the slave.
#pragma once

#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include <google/protobuf/util/time_util.h>
#include <grpcpp/grpcpp.h>
#include <palpate/v1/errors.pb.h>
#include <palpate/v1/state.pb.h>

namespace palpate {
// Its symbols are not those of the programs, whose classes have some of the same names.
inline namespace client {

using Vector = std::array<double, 3>;

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// A call that the slave rejected, or a lost connection. `what()` is the sentence of the slave.
class Error : public std::runtime_error {
 public:
  Error(grpc::StatusCode code, const std::string& details)
      : std::runtime_error(details), code_(code) {}
  explicit Error(const grpc::Status& status) : Error(status.error_code(), status.error_message()) {
    v1::ErrorStatus details;
    v1::ErrorInfo info;
    if (!details.ParseFromString(status.error_details()) || details.details().empty()) return;
    if (info.ParseFromString(details.details(0).value())) reason_ = info.reason();
  }
  [[nodiscard]] grpc::StatusCode code() const noexcept { return code_; }
  // Name of an ErrorReason in errors.proto, for example `LEASE_HELD`. Empty: none.
  [[nodiscard]] const std::string& reason() const noexcept { return reason_; }

 private:
  grpc::StatusCode code_;
  std::string reason_;
};

// Another client operates, or the operator was evicted.
class LeaseHeld : public Error {
  using Error::Error;
};

// The tool does not follow: the slave holds it, or an emergency stop is latched. Engage again.
class Interrupted : public Error {
  using Error::Error;
};

// This machine's time, for what is sent.
inline google::protobuf::Timestamp Now() {
  const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
  return google::protobuf::util::TimeUtil::NanosecondsToTimestamp(
      std::chrono::duration_cast<std::chrono::nanoseconds>(since_1970).count());
}

// The numbers of a Vec3 or Vec3f.
template <typename Message>
Vector ToVector(const Message& message) {
  return {message.x(), message.y(), message.z()};
}

inline void Set(const Vector& from, v1::Vec3* to) {
  to->set_x(from[0]);
  to->set_y(from[1]);
  to->set_z(from[2]);
}

inline double Dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline double Norm(const Vector& a) {
  return std::sqrt(Dot(a, a));
}

// The estimate at one instant. Numbers that are unknown are NaN.
class State {
 public:
  State() = default;
  explicit State(v1::SlaveState message) : message_(std::move(message)) {}

  // Everything that the slave sent.
  [[nodiscard]] const v1::SlaveState& message() const noexcept { return message_; }
  // Time of the image or tactile sample, slave's clock [s since 1970]. The force belongs to it.
  [[nodiscard]] double t() const noexcept {
    return static_cast<double>(message_.sensed_at().seconds()) +
           1e-9 * message_.sensed_at().nanos();
  }
  // Measured tool tip [m].
  [[nodiscard]] Vector tip() const { return ToVector(message_.p_s_tip()); }
  // Force of the object on the tool [N]. Use it as a measurement only if `valid()`.
  [[nodiscard]] Vector force() const {
    return known() ? ToVector(message_.force()) : Vector{kUnknown, kUnknown, kUnknown};
  }
  // One standard deviation of the force [N].
  [[nodiscard]] double sigma() const noexcept { return known() ? message_.sigma() : kUnknown; }
  // There is a force. A stale state repeats the last one, which may not hold any more.
  [[nodiscard]] bool known() const noexcept {
    return message_.has_force() && message_.validity() != v1::VALIDITY_STALE;
  }
  // The force is a measurement: all checks pass and the model is within its range.
  [[nodiscard]] bool valid() const noexcept { return message_.validity() == v1::VALIDITY_VALID; }

 private:
  v1::SlaveState message_;
};

}  // namespace client
}  // namespace palpate
