#include "slave/tactile/localise/direction_localiser.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "slave/tactile/localise/found_place.h"
#include "slave/tactile/localise/intensity.h"

namespace palpate {
namespace {

// Angles within which 68 % of the presses on a plate are (contact_direction_test.cpp). With
// pressure-weighted intensities it falls as the noise of a mean does with what is counted.
constexpr double kDegree = std::numbers::pi / 180;
constexpr double kPolarityFreeSigma = 8.4 * kDegree;
constexpr double kSigmaOfOneCount = 200 * kDegree;
constexpr double kLeastSigma = 4 * kDegree;
constexpr double kLargestSigma = 30 * kDegree;

double PressureWeightedSigma(double counts) noexcept {
  return std::clamp(kSigmaOfOneCount / std::sqrt(counts), kLeastSigma, kLargestSigma);
}

}  // namespace

DirectionLocaliser::DirectionLocaliser(const Tactile& tactile, const ElectrodeLayout& layout,
                                       Weighting weighting)
    : mean_(layout, tactile.finger_radius),
      check_(layout, tactile.threshold),
      weighting_(weighting),
      threshold_(tactile.threshold),
      full_scale_(tactile.full_scale) {}

std::string_view DirectionLocaliser::name() const {
  return weighting_ == Weighting::kPolarityFree ? "polarity-free" : "pressure-weighted";
}

TouchPlace DirectionLocaliser::Locate(const TactileSignals& change,
                                      const FingerReading& raw) const noexcept {
  const SignalFlaws flaws = check_.Check(change, raw);
  if (!flaws.finite) return NoPlace(TouchPlace::Status::kFailed);
  const bool is_polarity_free = weighting_ == Weighting::kPolarityFree;
  const Intensities intensities = is_polarity_free
                                      ? PolarityFree(change, flaws, threshold_, full_scale_)
                                      : PressureWeighted(change, flaws, threshold_);
  if (intensities.active == 0) return NoPlace(TouchPlace::Status::kNoContact, flaws.any());
  const auto direction = mean_.Mean(intensities);
  if (!direction) return NoPlace(TouchPlace::Status::kAtOrigin, flaws.any());
  const double sigma =
      is_polarity_free ? kPolarityFreeSigma : PressureWeightedSigma(intensities.total);
  return FoundPlace(mean_.surface(), mean_.PlaceOf(*direction), sigma, flaws.any(),
                    intensities.active);
}

}  // namespace palpate
