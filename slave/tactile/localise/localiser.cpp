#include "slave/tactile/localise/localiser.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "slave/tactile/localise/direction_mean.h"

namespace palpate {
namespace {

// Angle within which 68 % of the presses on a plate are (contact_direction_test.cpp): it decreases
// with the sum of the intensities as the noise of a mean does.
constexpr double kDegree = std::numbers::pi / 180;  // [rad] [by definition]
constexpr double kSigmaOfOneCount = 200 * kDegree;  // [rad] [tuned: SigmaHoldsTwoThirdsOfThePlaces]
constexpr double kMinSigma = 4 * kDegree;           // [rad] [tuned: SigmaHoldsTwoThirdsOfThePlaces]
constexpr double kMaxSigma = 30 * kDegree;

double PressureWeightedSigma(double counts) noexcept {
  return std::clamp(kSigmaOfOneCount / std::sqrt(counts), kMinSigma, kMaxSigma);
}

// DirectionMean with the intensities of PressureWeighted.
class PressureWeightedLocaliser final : public Localiser {
 public:
  PressureWeightedLocaliser(const ElectrodeLayout& layout, double radius)
      : mean_(layout, radius), check_(layout) {}

  [[nodiscard]] TouchPlace Locate(const TactileSignals& change,
                                  const FingerReading& raw) const noexcept override {
    const SignalFlaws flaws = check_.Check(change, raw);
    if (!flaws.finite) return NoPlace(TouchPlace::Status::kFailed);
    const Intensities intensities = PressureWeighted(change, flaws);
    if (intensities.active == 0) return NoPlace(TouchPlace::Status::kNoContact, flaws.any());
    const auto direction = mean_.Mean(intensities);
    if (!direction) return NoPlace(TouchPlace::Status::kAtOrigin, flaws.any());
    return FoundPlace(mean_.surface(), mean_.PlaceOf(*direction),
                      PressureWeightedSigma(intensities.total), flaws.any(), intensities.active);
  }
  [[nodiscard]] std::string_view name() const override { return "pressure-weighted"; }

 private:
  DirectionMean mean_;
  SignalCheck check_;
};

constexpr double kActiveNoise = 5;  // smallest change of an active channel [noise at rest]

class ChannelLocaliser final : public Localiser {
 public:
  ChannelLocaliser(double threshold, const ElectrodeLayout& layout)
      : layout_(layout), threshold_(threshold) {}

  [[nodiscard]] TouchPlace Locate(const TactileSignals& change,
                                  const FingerReading& /*raw*/) const noexcept override {
    TouchPlace place;
    double total = 0;
    for (std::size_t i = 0; i < layout_.p_F.size(); ++i) {
      const double size = std::abs(change[i]);
      if (!std::isfinite(size)) return NoPlace(TouchPlace::Status::kFailed);
      if (size <= threshold_) continue;
      place.p_F += size * layout_.p_F[i];
      place.n_F += size * layout_.n_F[i];
      total += size;
      ++place.active;
    }
    if (place.active == 0) return NoPlace(TouchPlace::Status::kNoContact);
    if (!(place.n_F.norm() > kCancelled * total)) return NoPlace(TouchPlace::Status::kAtOrigin);
    place.status = TouchPlace::Status::kFound;
    place.p_F /= total;
    place.n_F.normalize();
    return place;
  }
  [[nodiscard]] std::string_view name() const override { return "mean of the active channels"; }

 private:
  static constexpr double kCancelled = 1e-6;  // of the normals
  ElectrodeLayout layout_;
  double threshold_;  // [unit of the channels]
};

}  // namespace

std::unique_ptr<Localiser> MakeChannelLocaliser(double noise, const ElectrodeLayout& layout) {
  return std::make_unique<ChannelLocaliser>(kActiveNoise * noise, layout);
}

std::unique_ptr<Localiser> MakeLocaliser(const Tactile& tactile, const ElectrodeLayout& layout) {
  return std::make_unique<PressureWeightedLocaliser>(layout, tactile.finger_radius);
}

}  // namespace palpate
