#include "slave/checks/load/load_checks.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "slave/checks/chi_square.h"
#include "slave/checks/load/dome_rest_shape.h"
#include "slave/checks/load/encoder_depth.h"
#include "slave/checks/load/flat_at_rest.h"
#include "slave/checks/load/load_limits.h"
#include "slave/checks/load/tension.h"

namespace palpate {
namespace {

// Checks that the load is within the range of its model.
class ModelRangeCheck final : public Check<FitSample> {
 public:
  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (sample.beyond_range.empty()) return;
    findings->Fail(FailedCheck::kModelRange, sample.beyond_range);
  }
};

// Checks that cameras and rim have moved no farther than is compensated.
class RigMotionCheck final : public Check<FitSample> {
 public:
  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (!sample.plate->moved || sample.plate->compensated) return;
    findings->Fail(FailedCheck::kCameraMotion,
                   "the cameras or the membrane's rim have moved since the rest images");
  }
};

// Checks that distances of the points along the plate are those at rest.
class GrowthCheck final : public Check<FitSample> {
 public:
  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (!sample.plate->growth.IsSignificant(LoadLimits::kWaldSigmas)) return;
    findings->Fail(FailedCheck::kScale,
                   "the distances of the points have changed since rest: zoom");
  }
};

// Checks that the load presses, because a tool cannot pull: a pulling load indicates exchanged
// cameras or a wrong pose.
class PullCheck final : public Check<LoadSample> {
 public:
  void Examine(const LoadSample& sample, Findings* findings) noexcept override {
    if (!(sample.load.force > sample.load.sigma_force)) return;
    findings->Fail(FailedCheck::kMisfit,
                   "the load pulls outward: check the sides (left, right), the rig and the "
                   "object's pose");
  }
};

// Checks the distances: a common error of all distances is an error of the force.
class ScaleCheck final : public Check<LoadSample> {
 public:
  void Examine(const LoadSample& sample, Findings* findings) noexcept override {
    findings->Widen(LoadLimits::kForceOfScale * sample.seen.scale_error * sample.load.force);
  }
};

// Tests whether one load explains the measured displacements: reduced chi-square of the residuals
// against their noise, with a share of the deflection for the error of the model.
class ResidualCheck final : public Check<FitSample> {
 public:
  // `noise`: residual that is accepted while that without contact is unknown [sigma].
  // `model_error`: relative to the largest deflection [-].
  ResidualCheck(double noise, double model_error) : noise_(noise), model_error_(model_error) {}

  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (sample.left_out > LoadLimits::kMaxLeftOut * sample.points) {
      findings->Fail(FailedCheck::kMisfit,
                     "more than a quarter of the points contradict the others");
    }
    const double rest = sample.rest_residual;
    // Without a load the residual updates that at rest.
    const bool is_known = rest > 0 && sample.freedom > 0 && sample.load.force != 0;
    const double noise =
        is_known ? rest * rest * ChiSquareGate(sample.freedom) / sample.freedom : noise_ * noise_;
    const double model = sample.sigma > 0 ? model_error_ * sample.deepest / sample.sigma : 0;
    if (sample.load.residual * sample.load.residual <= noise + model * model) return;
    findings->Fail(FailedCheck::kMisfit,
                   "no load of this width explains the measured surface within its noise");
  }

 private:
  double noise_, model_error_;
};

// Checks the force error by errors of the timestamps: the change of the force in that time.
class TimingCheck final : public Check<LoadSample> {
 public:
  // Uses the larger of two changes, because at a reversal of the tool one is near zero. Changes
  // within the noise are ignored.
  void Examine(const LoadSample& sample, Findings* findings) noexcept override {
    if (!IsForceKnown(sample.load.validity)) return;
    const double force = sample.load.force;
    const double change = last_force_ ? std::abs(force - *last_force_) : 0;
    last_force_ = force;
    const double largest = std::max(change, std::exchange(last_change_, change));
    const double noise = kNoChange * std::hypot(sample.load.sigma_force, findings->sigma_force);
    findings->Widen(sample.seen.moment_sigma * std::max(0.0, largest - noise));
  }
  void Reset() noexcept override {
    last_force_.reset();
    last_change_ = 0;
  }

 private:
  // Change of the force from pair to pair that is noise [sigma]. [tuned: skew_test]
  static constexpr double kNoChange = 2;
  std::optional<double> last_force_;  // outward [N]
  double last_change_ = 0;            // change between the two previous pairs [N]
};

}  // namespace

Checks<FitSample> MakePlateChecks(double radius, double thickness, double prestress) {
  Checks<FitSample> checks;
  checks.Add(std::make_unique<ModelRangeCheck>());
  checks.Add(std::make_unique<ResidualCheck>(LoadLimits::kGoodFit, LoadLimits::kModelError));
  checks.Add(std::make_unique<RigMotionCheck>());
  checks.Add(std::make_unique<GrowthCheck>());
  checks.Add(std::make_unique<FlatAtRestCheck>(radius, thickness));
  checks.Add(std::make_unique<TensionCheck>(prestress));
  return checks;
}

Checks<FitSample> MakeDomeChecks(const std::optional<Ellipsoid>& rest) {
  Checks<FitSample> checks;
  checks.Add(std::make_unique<ModelRangeCheck>());
  checks.Add(std::make_unique<ResidualCheck>(LoadLimits::kGoodDome, LoadLimits::kTrueIndentation));
  if (rest) checks.Add(std::make_unique<DomeRestShapeCheck>(*rest));
  return checks;
}

Checks<FitSample> MakeVolumeChecks() {
  Checks<FitSample> checks;
  checks.Add(std::make_unique<ModelRangeCheck>());
  checks.Add(std::make_unique<ResidualCheck>(LoadLimits::kGoodFit, 0));
  return checks;
}

Checks<LoadSample> MakeLoadChecks() {
  Checks<LoadSample> checks;
  checks.Add(std::make_unique<PullCheck>());
  checks.Add(std::make_unique<ScaleCheck>());
  checks.Add(std::make_unique<TimingCheck>());
  checks.Add(std::make_unique<EncoderDepthCheck>());
  return checks;
}

}  // namespace palpate
