#include "slave/tactile/localise/fitted_localiser.h"

#include <string_view>
#include <utility>

#include "slave/tactile/localise/direction_mean.h"
#include "slave/tactile/localise/found_place.h"
#include "slave/tactile/localise/intensity.h"
#include "slave/tactile/localise/normal_correction.h"
#include "slave/tactile/localise/signal_check.h"

namespace palpate {
namespace {

class FittedLocaliser final : public Localiser {
 public:
  FittedLocaliser(LocaliserWeights weights, double radius)
      : weights_(std::move(weights)),
        mean_(weights_.layout, radius),
        check_(weights_.layout, weights_.threshold) {}

  [[nodiscard]] TouchPlace Locate(const TactileSignals& change,
                                  const FingerReading& raw) const noexcept override {
    const SignalFlaws flaws = check_.Check(change, raw);
    if (!flaws.finite) return NoPlace(TouchPlace::Status::kFailed);
    const Intensities intensities = PressureWeighted(change, flaws, weights_.threshold);
    if (intensities.active == 0) return NoPlace(TouchPlace::Status::kNoContact, flaws.any());
    const auto direction = mean_.Mean(intensities);
    if (!direction) return NoPlace(TouchPlace::Status::kAtOrigin, flaws.any());
    const Eigen::Vector3d n_F =
        weights_.R * direction->n_F + Correction(weights_, ShapeOf(change, weights_.quiet));
    if (!(n_F.norm() > kCancelled)) return NoPlace(TouchPlace::Status::kAtOrigin, flaws.any());
    const Eigen::Vector3d p_F = mean_.PlaceOf({n_F.normalized(), direction->axis_x});
    return FoundPlace(mean_.surface(), p_F, weights_.sigma_angle, flaws.any(), intensities.active);
  }
  [[nodiscard]] std::string_view name() const override { return "fitted"; }

 private:
  static constexpr double kCancelled = 1e-6;

  LocaliserWeights weights_;
  DirectionMean mean_;
  SignalCheck check_;
};

}  // namespace

std::unique_ptr<Localiser> MakeFittedLocaliser(LocaliserWeights weights, double finger_radius) {
  return std::make_unique<FittedLocaliser>(std::move(weights), finger_radius);
}

}  // namespace palpate
