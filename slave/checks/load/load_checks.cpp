#include "slave/checks/load/load_checks.h"

#include "slave/checks/load/dome_rest_shape.h"
#include "slave/checks/load/encoder_depth.h"
#include "slave/checks/load/flat_at_rest.h"
#include "slave/checks/load/load_limits.h"
#include "slave/checks/load/residual.h"
#include "slave/checks/load/tension.h"
#include "slave/checks/load/timing.h"

namespace palpate {
namespace {

// The load is within the range of its model.
class ModelRangeCheck final : public Check<FitSample> {
 public:
  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (sample.beyond_range.empty()) return;
    findings->Fail(FailedCheck::kModelRange, sample.beyond_range);
  }
};

// Cameras and rim have moved no farther than is compensated.
class RigMotionCheck final : public Check<FitSample> {
 public:
  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (!sample.plate->moved || sample.plate->compensated) return;
    findings->Fail(FailedCheck::kCameraMotion,
                   "the cameras or the membrane's rim have moved since the rest images");
  }
};

// The points are as far apart along the plate as at rest.
class GrowthCheck final : public Check<FitSample> {
 public:
  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (!sample.plate->growth.IsSignificant(LoadLimits::kWaldSigmas)) return;
    findings->Fail(FailedCheck::kScale,
                   "the distances of the points have changed since rest: zoom");
  }
};

// A tool can only press: a load that pulls comes from exchanged cameras or a wrong pose.
class PullCheck final : public Check<LoadSample> {
 public:
  void Examine(const LoadSample& sample, Findings* findings) noexcept override {
    if (!(sample.load.force > sample.load.sigma_force)) return;
    findings->Fail(FailedCheck::kMisfit,
                   "the load pulls outward: check the sides (left, right), the rig and the "
                   "object's pose");
  }
};

// An error of all distances is an error of the force.
class ScaleCheck final : public Check<LoadSample> {
 public:
  void Examine(const LoadSample& sample, Findings* findings) noexcept override {
    findings->Widen(LoadLimits::kForceOfScale * sample.seen.scale_error * sample.load.force);
  }
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
