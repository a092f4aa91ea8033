#include "slave/checks/points/points_checks.h"

#include "slave/checks/points/dots_at_rest.h"
#include "slave/checks/points/epipolar.h"
#include "slave/checks/points/frozen_source.h"
#include "slave/checks/points/membrane_distance.h"

namespace palpate {

Checks<PointsSample> MakePointsChecks(const Scene& scene, const StereoRig& rig) {
  Checks<PointsSample> checks;
  checks.Add("frozen_source", std::make_unique<FrozenSourceCheck>());
  const PointTracking& points = *scene.sense.Find<PointTracking>();
  if (const auto* depth = scene.sense.Find<DepthPictures>()) {
    checks.Add("membrane_distance", std::make_unique<MembraneDistanceCheck>(scene, depth->X_SD));
    return checks;
  }
  const StereoCameras& pair = *scene.sense.Find<StereoCameras>();
  const bool is_exact = pair.source == StereoCameras::Source::kSimulated;
  checks.Add("epipolar",
             std::make_unique<EpipolarCheck>(
                 rig, PointsLimits::kLearning, points.sigma,
                 is_exact ? PointsLimits::kMostAtRestOfExactRig : PointsLimits::kMostAtRest));
  if (points.track == PointTracking::Track::kDots) {
    checks.Add("dots_at_rest", std::make_unique<DotsAtRestCheck>());
  } else {
    checks.Add("membrane_distance", std::make_unique<MembraneDistanceCheck>(scene, pair.X_SL));
  }
  return checks;
}

}  // namespace palpate
