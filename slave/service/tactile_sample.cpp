#include "slave/service/tactile_sample.h"

#include <cmath>

#include "shared/wire/fields.h"

namespace palpate {
namespace {

constexpr double kUnitTolerance = 0.01;  // of a quaternion's length
constexpr int kQuaternion = 4;

std::optional<Eigen::Isometry3d> ReadPose(const v1::TactileSample& message, FieldReader* reader) {
  const auto& q = message.orientation();
  if (!message.has_p_s_finger() && q.empty()) return std::nullopt;
  reader->Require(message.has_p_s_finger(), "p_S_finger is absent", "a place with an orientation");
  reader->Require(q.size() == kQuaternion,
                  "orientation of " + std::to_string(q.size()) + " numbers",
                  "four with p_S_finger: w, x, y, z");
  if (!reader->ok()) return std::nullopt;
  const Eigen::Vector3d p_S = reader->Vector("p_S_finger", message.p_s_finger(), kMaxLength);
  const Eigen::Quaterniond q_SF(q[0], q[1], q[2], q[3]);
  reader->Require(std::abs(q_SF.norm() - 1) <= kUnitTolerance,  // so written, NaN is refused too
                  "orientation of length " + std::to_string(q_SF.norm()), "a unit quaternion");
  if (!reader->ok()) return std::nullopt;
  Eigen::Isometry3d X_SF = Eigen::Isometry3d::Identity();
  X_SF.translate(p_S).rotate(q_SF.normalized());
  return X_SF;
}

}  // namespace

std::optional<TactileSample> FromProto(const v1::TactileSample& message, std::string* reason) {
  constexpr int kMostPressures = 2;  // pdc, pac0
  const auto& electrodes = message.electrodes();
  const auto& pressure = message.pressure();
  FieldReader reader(reason);
  reader.Require(message.has_sensed_at(), "sensed_at is absent", "a time");
  reader.Require(electrodes.size() == kElectrodeCount,
                 std::to_string(electrodes.size()) + " electrodes",
                 std::to_string(kElectrodeCount) + ", E1 to E19");
  reader.Require(pressure.size() <= kMostPressures, std::to_string(pressure.size()) + " pressures",
                 "at most two: pdc, pac0");
  if (!reader.ok()) return std::nullopt;
  TactileSample sample;
  sample.sensed_at = reader.Stamp("sensed_at", message.sensed_at());
  std::copy(electrodes.begin(), electrodes.end(), sample.reading.electrodes.begin());
  if (pressure.size() > 0) sample.reading.pdc = pressure[0];
  if (pressure.size() > 1) sample.reading.pac = pressure[1];
  sample.reading.X_SF = ReadPose(message, &reader);
  if (!reader.ok()) return std::nullopt;
  return sample;
}

}  // namespace palpate
