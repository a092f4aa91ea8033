// Conversion of numbers, vectors and timestamps in messages. Reading checks each of them.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "palpate/v1/state.pb.h"

#include "google/protobuf/timestamp.pb.h"
#include "shared/state/clock.h"
#include "shared/state/datagram_count.h"
#include "shared/state/slave_state.h"
#include "shared/state/validity.h"

namespace palpate {

// Largest accepted values, far above any scene (1 nm to 1 km, 1 Pa to 1 TPa).
inline constexpr double kMaxLength = 1e6;      // [m]
inline constexpr double kMaxSpeed = 1e6;       // [m/s]
inline constexpr double kMaxForce = 1e18;      // [N]
inline constexpr double kMaxMoment = 1e24;     // [N m]
inline constexpr double kMaxStiffness = 1e21;  // [N/m]
inline constexpr double kMaxDelay = 1e6;       // [s]

// Accepted deviation of the length of a sent unit quaternion or vector from 1 [-]. [derived: single
// precision leaves 1e-7; more than this is not a rounded unit]
inline constexpr double kUnitTolerance = 1e-3;

// Nearest single-precision number, limited to the largest finite one. NaN stays.
inline float Narrow(double value) {
  constexpr double kMaxFloat = std::numeric_limits<float>::max();
  return static_cast<float>(std::clamp(value, -kMaxFloat, kMaxFloat));
}

void ToProto(const Eigen::Vector3d& vector, v1::Vec3* message);
void ToProto(const Eigen::Vector3d& vector, v1::Vec3f* message);
// Four numbers w, x, y, z; none for nullopt.
void ToProto(const std::optional<Eigen::Quaterniond>& rotation,
             google::protobuf::RepeatedField<double>* message);
void ToProto(Time time, google::protobuf::Timestamp* message);
void ToProto(const DatagramCount& count, v1::DatagramCount* message);
DatagramCount FromProto(const v1::DatagramCount& count);

// Reads fields and stores the reason of the first rejection:
// `p_M.x = nan: expected a finite number, at most 1e+06 in size`. Results are finite and in
// range; rejected fields become zero.
class FieldReader {
 public:
  // `reason` must outlive the reader. It is written only at a rejection.
  explicit FieldReader(std::string* reason) : reason_(reason) {}
  [[nodiscard]] bool ok() const { return ok_; }

  // |value| <= limit.
  double Number(std::string_view name, double value, double limit);
  // 0 <= value <= limit.
  double NonNegative(std::string_view name, double value, double limit);
  Eigen::Vector3d Vector(std::string_view name, const v1::Vec3& value, double limit);
  Eigen::Vector3d Vector(std::string_view name, const v1::Vec3f& value, double limit);
  // Accepts no numbers, or four numbers w, x, y, z whose length is 1 within kUnitTolerance; the
  // result is a unit quaternion. nullopt: none, or rejected.
  std::optional<Eigen::Quaterniond> Rotation(std::string_view name,
                                             const google::protobuf::RepeatedField<double>& value);
  // 1970 to 2242, 0 <= nanos < 1e9.
  Time Stamp(std::string_view name, const google::protobuf::Timestamp& value);
  // Rejects unless `condition`: `name`: expected `accepted`.
  void Require(bool condition, std::string_view name, std::string_view accepted);

 private:
  void Refuse(const std::string& reason);

  std::string* reason_;
  bool ok_ = true;
};

// Enumerations <-> those of palpate/v1/state.proto. Unknown values of newer peers become the safest
// known value.
v1::Validity ToProto(Validity validity);
// Unknown and unspecified: kFailed.
Validity FromProto(v1::Validity validity);
v1::FailedCheck ToProto(FailedCheck check);
// Unknown values become kNone; the validity still counts.
FailedCheck FromProto(v1::FailedCheck check);

v1::Phase ToProto(Phase phase);
// Unknown and unspecified: kHold.
Phase FromProto(v1::Phase phase);

v1::Event ToProto(Event event);
// Every known event of `events`, each once, in the order of the enumeration.
void ToProto(const Events& events, google::protobuf::RepeatedField<int>* message);
// Unknown and unspecified events are ignored.
Events FromProto(const google::protobuf::RepeatedField<int>& message);

}  // namespace palpate
