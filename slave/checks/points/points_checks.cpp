#include "slave/checks/points/points_checks.h"

#include "slave/checks/points/epipolar.h"
#include "slave/checks/points/membrane_distance.h"
#include "slave/checks/points/points_limits.h"
#include "slave/checks/repeat_detector.h"

namespace palpate {
namespace {

// Checks that images of a pair or depth camera do not repeat.
class FrozenSourceCheck final : public Check<PointsSample> {
 public:
  void Examine(const PointsSample& sample, Findings* findings) noexcept override {
    if (!detector_.Repeats(sample.left, sample.right)) return;
    findings->Fail(FailedCheck::kFrozen, "a camera repeats the same image: it is frozen");
  }

 private:
  RepeatDetector detector_{{.learning = PointsLimits::kLearning}};
};

// Checks that spacing and position of the dots at rest are those of the layout.
class DotsAtRestCheck final : public Check<PointsSample> {
 public:
  void Examine(const PointsSample& sample, Findings* findings) noexcept override {
    if (sample.seen.scale_error > PointsLimits::kTrueSize) {
      findings->Fail(FailedCheck::kScale,
                     "the distances of the dots differ from the layout: check the rig and the "
                     "layout");
    }
    if (sample.seen.place_error > PointsLimits::kTruePlace) {
      findings->Fail(FailedCheck::kRegistration,
                     "the positions of the dots differ from the layout: check the pose and the "
                     "layout");
    }
  }
};

}  // namespace

Checks<PointsSample> MakePointsChecks(const Scene& scene, const StereoRig& rig,
                                      const SurfaceMesh& surface_O,
                                      std::optional<RestSurface>* rest) {
  Checks<PointsSample> checks;
  checks.Add(std::make_unique<FrozenSourceCheck>());
  if (!surface_O.triangles.empty()) {
    checks.Add(std::make_unique<RestSurfaceCheck>(scene, surface_O, rest));
  }
  const PointTracking& points = *scene.sense.Find<PointTracking>();
  if (const auto* depth = scene.sense.Find<DepthImages>()) {
    checks.Add(std::make_unique<MembraneDistanceCheck>(scene, depth->X_SD));
    return checks;
  }
  const StereoCameras& pair = *scene.sense.Find<StereoCameras>();
  const bool is_exact = pair.source == StereoCameras::Source::kSimulated;
  checks.Add(std::make_unique<EpipolarCheck>(
      rig, PointsLimits::kLearning, points.sigma,
      is_exact ? PointsLimits::kMaxAtRestOfExactRig : PointsLimits::kMaxAtRest));
  if (points.track == PointTracking::Track::kDots) {
    checks.Add(std::make_unique<DotsAtRestCheck>());
  } else {
    checks.Add(std::make_unique<MembraneDistanceCheck>(scene, pair.X_SL));
  }
  return checks;
}

}  // namespace palpate
