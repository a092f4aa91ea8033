// What the slave is asked and fed.
#include <cmath>
#include <stdexcept>

#include "shared/text/text.h"
#include "shared/wire/fields.h"
#include "slave/service/messages.h"

namespace palpate {
namespace {

constexpr double kBulkRate = 30, kMaxBulkRate = 120;             // [Hz]
constexpr double kTraceRate = 10;                                // [Hz]
constexpr double kMaxStateRate = 1000;                           // [Hz]
constexpr double kMaxForceLimit = 100;                           // [N]
constexpr double kMinYoungModulus = 1, kMaxYoungModulus = 1e13;  // [Pa]
constexpr std::size_t kLongestWord = 40;  // [characters]; no accepted one is longer
constexpr unsigned kQuality = 80, kMinQuality = 10, kMaxQuality = 100;

[[noreturn]] void Refuse(const char* field, const std::string& value, const std::string& accepted) {
  throw std::invalid_argument(std::string(field) + " = " + value + ": expected " + accepted);
}

Clock::duration Gap(double rate, double rate_for_zero, double max_rate) {
  if (!(rate == 0 || (rate >= 1 && rate <= max_rate))) {  // so written, NaN is refused too
    Refuse("max_rate", Formatted("%g", rate), Formatted("0, or 1 to %g", max_rate));
  }
  if (rate == 0) rate = rate_for_zero;
  return rate > 0 ? Seconds(1 / rate) : Clock::duration::zero();
}

double Scale(const char* field, double value, double max) {
  if (value >= kLeastSetting && value <= max) return value;
  Refuse(field, Formatted("%g", value),
         Formatted("%g", kLeastSetting) + " to " + Formatted("%g", max));
}

std::optional<Eigen::Isometry3d> ReadPose(const v1::TactileSample& message, FieldReader* reader) {
  if (!message.has_p_s_finger() && message.orientation().empty()) return std::nullopt;
  reader->Require(message.has_p_s_finger(), "p_S_finger is absent",
                  "a position with an orientation");
  reader->Require(!message.orientation().empty(), "orientation is absent",
                  "an orientation with p_S_finger");
  if (!reader->ok()) return std::nullopt;
  const Eigen::Vector3d p_S = reader->Vector("p_S_finger", message.p_s_finger(), kMaxLength);
  const auto R_SF = reader->Rotation("orientation", message.orientation());
  if (!reader->ok()) return std::nullopt;
  Eigen::Isometry3d X_SF = Eigen::Isometry3d::Identity();
  X_SF.translate(p_S).rotate(*R_SF);
  return X_SF;
}

}  // namespace

Clock::duration GapOf(const v1::WatchStateRequest& request) {
  return Gap(request.max_rate(), 0, kMaxStateRate);
}

Clock::duration GapOf(const v1::WatchMeshRequest& request) {
  return Gap(request.max_rate(), kBulkRate, kMaxBulkRate);
}

Clock::duration GapOf(const v1::WatchImagesRequest& request) {
  return Gap(request.max_rate(), kBulkRate, kMaxBulkRate);
}

Clock::duration GapOf(const v1::WatchTraceRequest& request) {
  return Gap(request.max_rate(), kTraceRate, kMaxBulkRate);
}

int QualityOf(const v1::WatchImagesRequest& request) {
  const unsigned quality = request.quality() == 0 ? kQuality : request.quality();
  if (quality < kMinQuality || quality > kMaxQuality)
    Refuse("quality", std::to_string(quality), "0, or 10 to 100");
  return static_cast<int>(quality);
}

ParameterChange ToChange(const v1::SetParametersRequest& request) {
  ParameterChange change;
  if (request.has_position_scale()) {
    change.position_scale = Scale("position_scale", request.position_scale(), kMaxPositionScale);
  }
  if (request.has_force_scale()) {
    change.force_scale = Scale("force_scale", request.force_scale(), kMaxForceScale);
  }
  if (request.has_force_limit()) {
    change.force_limit = Scale("force_limit", request.force_limit(), kMaxForceLimit);
  }
  if (request.has_young_modulus()) {
    const double E = request.young_modulus();
    if (!(E >= kMinYoungModulus && E <= kMaxYoungModulus)) {
      Refuse("young_modulus", Formatted("%g", E), "1 to 1e13");
    }
    change.young_modulus = E;
  }
  return change;
}

ModelChange ToChange(const v1::SetModelRequest& request) {
  return {.kind = Presentable(request.kind(), kLongestWord)};
}

std::optional<TactileSample> FromProto(const v1::TactileSample& message, std::string* reason) {
  constexpr int kMostPressures = 2;  // pdc, pac0
  const auto& electrodes = message.electrodes();
  const auto& pressure = message.pressure();
  FieldReader reader(reason);
  reader.Require(message.has_sensed_at(), "sensed_at is absent", "a time");
  reader.Require(electrodes.size() >= 1 && electrodes.size() <= kMaxChannels,
                 std::to_string(electrodes.size()) + " channels",
                 "1 to " + std::to_string(kMaxChannels));
  reader.Require(pressure.size() <= kMostPressures, std::to_string(pressure.size()) + " pressures",
                 "at most two: pdc, pac0");
  if (!reader.ok()) return std::nullopt;
  TactileSample sample;
  sample.sensed_at = reader.Stamp("sensed_at", message.sensed_at());
  sample.reading.channels.resize(static_cast<std::size_t>(electrodes.size()));
  std::copy(electrodes.begin(), electrodes.end(), sample.reading.channels.begin());
  if (pressure.size() > 0) sample.reading.pdc = pressure[0];
  if (pressure.size() > 1) sample.reading.pac = pressure[1];
  sample.reading.X_SF = ReadPose(message, &reader);
  if (!reader.ok()) return std::nullopt;
  return sample;
}

}  // namespace palpate
