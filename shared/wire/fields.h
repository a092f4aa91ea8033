// The pieces of which messages consist: numbers, vectors, stamps. Reading checks every one of them.
#pragma once

#include <algorithm>
#include <limits>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "palpate/v1/state.pb.h"

#include "google/protobuf/timestamp.pb.h"
#include "shared/state/clock.h"
#include "shared/state/datagram_count.h"
#include "shared/state/slave_state.h"
#include "shared/state/validity.h"

namespace palpate {

// What lies beyond is no scene of ours (1 nm to 1 km, 1 Pa to 1 TPa) but a mistake.
inline constexpr double kMaxLength = 1e6;      // [m]
inline constexpr double kMaxSpeed = 1e6;       // [m/s]
inline constexpr double kMaxForce = 1e18;      // [N]
inline constexpr double kMaxStiffness = 1e21;  // [N/m]
inline constexpr double kMaxEnergy = 1e24;     // [J]
inline constexpr double kMaxDelay = 1e6;       // [s]

// Nearest single precision number; what is too large becomes the largest. NaN stays.
inline float Narrow(double value) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  return static_cast<float>(std::clamp(value, -kLargest, kLargest));
}

void ToProto(const Eigen::Vector3d& vector, v1::Vec3* message);
void ToProto(const Eigen::Vector3d& vector, v1::Vec3f* message);
void ToProto(Time time, google::protobuf::Timestamp* message);
void ToProto(const DatagramCount& count, v1::DatagramCount* message);
DatagramCount FromProto(const v1::DatagramCount& count);

// Reads fields one after the other and remembers the first that cannot be accepted, in words:
// `p_M.x = nan: accepted is a finite number, at most 1e+06 in size`. What it returns is finite and
// in range, zero where the field was refused.
class FieldReader {
 public:
  // `reason` outlives the reader; it is written only when something is refused.
  explicit FieldReader(std::string* reason) : reason_(reason) {}
  [[nodiscard]] bool ok() const { return ok_; }

  // |value| <= limit.
  double Number(std::string_view name, double value, double limit);
  // 0 <= value <= limit.
  double NonNegative(std::string_view name, double value, double limit);
  Eigen::Vector3d Vector(std::string_view name, const v1::Vec3& value, double limit);
  Eigen::Vector3d Vector(std::string_view name, const v1::Vec3f& value, double limit);
  // 1970 to 2242, 0 <= nanos < 1e9.
  Time Stamp(std::string_view name, const google::protobuf::Timestamp& value);
  // Refuses unless `condition`: `name`: accepted is `accepted`.
  void Require(bool condition, std::string_view name, std::string_view accepted);

 private:
  void Refuse(const std::string& reason);

  std::string* reason_;
  bool ok_ = true;
};

// Domain enumerations <-> those of palpate/v1/state.proto. What a newer peer may have added is read
// as the most careful known value.
v1::Validity ToProto(Validity validity);
// Unknown and unspecified: kFailed.
Validity FromProto(v1::Validity validity);
v1::FailedCheck ToProto(FailedCheck check);
// One not known here is told as none: `validity` says enough.
FailedCheck FromProto(v1::FailedCheck check);

v1::Phase ToProto(Phase phase);
// Unknown and unspecified: kHold, the tool stands.
Phase FromProto(v1::Phase phase);

v1::Event ToProto(Event event);
// Every known event of `events`, each once, in the order of the enumeration.
void ToProto(const Events& events, google::protobuf::RepeatedField<int>* message);
// Unknown and unspecified ones are left out.
Events FromProto(const google::protobuf::RepeatedField<int>& message);

}  // namespace palpate
