#include "slave/service/requests.h"

#include <sstream>
#include <stdexcept>

namespace palpate {
namespace {

constexpr double kBulkRate = 30, kMaxBulkRate = 120;             // [Hz]
constexpr double kMaxStateRate = 1000;                           // [Hz]
constexpr double kMaxForceLimit = 100;                           // [N]
constexpr double kMinYoungModulus = 1, kMaxYoungModulus = 1e13;  // [Pa]
constexpr unsigned kMinElements = 3, kMaxElements = 4000;
constexpr unsigned kQuality = 80, kMinQuality = 10, kMaxQuality = 100;

template <class Number>
[[noreturn]] void Refuse(const char* field, Number value, const std::string& accepted) {
  std::ostringstream text;
  text << field << " = " << value << ": accepted is " << accepted;
  throw std::invalid_argument(text.str());
}

Clock::duration Gap(double rate, double rate_for_zero, double max_rate) {
  if (!(rate == 0 || (rate >= 1 && rate <= max_rate))) {  // so written, NaN is refused too
    std::ostringstream accepted;
    accepted << "0, or 1 to " << max_rate;
    Refuse("max_rate_hz", rate, accepted.str());
  }
  if (rate == 0) rate = rate_for_zero;
  return rate > 0 ? Seconds(1 / rate) : Clock::duration::zero();
}

// Nothing accepted is longer, and whoever is refused needs to read no more.
std::string Shortened(const std::string& word) {
  constexpr std::size_t kLongestWord = 40;  // [bytes]
  return word.size() <= kLongestWord ? word : word.substr(0, kLongestWord) + "...";
}

// `value` in (0, max].
double Scale(const char* field, double value, double max) {
  if (value > 0 && value <= max) return value;
  std::ostringstream accepted;
  accepted << "0 < x <= " << max;
  Refuse(field, value, accepted.str());
}

}  // namespace

Clock::duration GapOf(const v1::WatchStateRequest& request) {
  return Gap(request.max_rate_hz(), 0, kMaxStateRate);
}

Clock::duration GapOf(const v1::WatchMeshRequest& request) {
  return Gap(request.max_rate_hz(), kBulkRate, kMaxBulkRate);
}

Clock::duration GapOf(const v1::WatchVideoRequest& request) {
  return Gap(request.max_rate_hz(), kBulkRate, kMaxBulkRate);
}

int QualityOf(const v1::WatchVideoRequest& request) {
  const unsigned quality = request.quality() == 0 ? kQuality : request.quality();
  if (quality < kMinQuality || quality > kMaxQuality) Refuse("quality", quality, "0, or 10 to 100");
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
      Refuse("young_modulus", E, "1 to 1e13");
    }
    change.young_modulus = E;
  }
  return change;
}

ModelChange ToChange(const v1::SetModelRequest& request) {
  const unsigned elements = request.elements();
  if (elements != 0 && (elements < kMinElements || elements > kMaxElements)) {
    Refuse("elements", elements, "0, or 3 to 4000");
  }
  return {Shortened(request.kind()), static_cast<int>(elements), Shortened(request.plane()),
          Shortened(request.contact())};
}

}  // namespace palpate
