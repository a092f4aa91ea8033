#include "slave/checks/load/load_checks.h"

#include "slave/checks/load/contradicting_points.h"
#include "slave/checks/load/dome_at_rest.h"
#include "slave/checks/load/dome_residual.h"
#include "slave/checks/load/encoder_depth.h"
#include "slave/checks/load/flat_at_rest.h"
#include "slave/checks/load/growth.h"
#include "slave/checks/load/model_range.h"
#include "slave/checks/load/neighbours.h"
#include "slave/checks/load/outward.h"
#include "slave/checks/load/pull.h"
#include "slave/checks/load/residual.h"
#include "slave/checks/load/rig_motion.h"
#include "slave/checks/load/scale.h"
#include "slave/checks/load/scatter.h"
#include "slave/checks/load/tension.h"
#include "slave/checks/load/timing.h"

namespace palpate {

Checks<FitSample> MakePlateChecks(double radius, double thickness, double prestress) {
  Checks<FitSample> checks;
  checks.Add("model_range", std::make_unique<ModelRangeCheck>());
  checks.Add("contradicting_points", std::make_unique<ContradictingPointsCheck>());
  checks.Add("neighbours", std::make_unique<NeighboursCheck>());
  checks.Add("scatter", std::make_unique<ScatterCheck>());
  checks.Add("rig_motion", std::make_unique<RigMotionCheck>());
  checks.Add("growth", std::make_unique<GrowthCheck>());
  checks.Add("flat_at_rest", std::make_unique<FlatAtRestCheck>(radius, thickness));
  checks.Add("tension", std::make_unique<TensionCheck>(prestress));
  return checks;
}

Checks<FitSample> MakeDomeChecks(const std::optional<Ellipsoid>& rest, double model_error) {
  Checks<FitSample> checks;
  checks.Add("model_range", std::make_unique<ModelRangeCheck>());
  checks.Add("dome_residual", std::make_unique<DomeResidualCheck>(model_error));
  if (!rest) return checks;
  checks.Add("outward", std::make_unique<OutwardCheck>(*rest));
  checks.Add("dome_at_rest", std::make_unique<DomeAtRestCheck>(*rest));
  return checks;
}

Checks<FitSample> MakeVolumeChecks() {
  Checks<FitSample> checks;
  checks.Add("model_range", std::make_unique<ModelRangeCheck>());
  checks.Add("residual", std::make_unique<ResidualCheck>());
  checks.Add("contradicting_points", std::make_unique<ContradictingPointsCheck>());
  return checks;
}

Checks<LoadSample> MakeLoadChecks() {
  Checks<LoadSample> checks;
  checks.Add("pull", std::make_unique<PullCheck>());
  checks.Add("scale", std::make_unique<ScaleCheck>());
  checks.Add("timing", std::make_unique<TimingCheck>());
  checks.Add("encoder_depth", std::make_unique<EncoderDepthCheck>());
  return checks;
}

}  // namespace palpate
