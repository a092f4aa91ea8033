// Converts requests and driver messages.
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
constexpr std::size_t kMaxWordLength = 40;  // [characters]; no accepted one is longer
constexpr unsigned kDefaultQuality = 80, kMinQuality = 10, kMaxQuality = 100;

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
  if (value >= kMinSetting && value <= max) return value;
  Refuse(field, Formatted("%g", value),
         Formatted("%g", kMinSetting) + " to " + Formatted("%g", max));
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
  const unsigned quality = request.quality() == 0 ? kDefaultQuality : request.quality();
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
  return {.kind = Presentable(request.kind(), kMaxWordLength)};
}

}  // namespace palpate
