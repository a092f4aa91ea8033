#include "slave/checks/load/encoder_depth.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

// Accepted difference of the two depths: relative to the larger side, and relative to the depth
// [-]. [tuned: depth late]
constexpr double kParts = 0.0012, kShare = 0.02;
// Distance of a load from the tip [sigma]. [tuned: surface_flags_test, an indentation not under
// the tip]
constexpr double kPlaceSigmas = 3;
// Limits of the disagreement: relative to the force, and to the larger side [-]. [tuned: depth
// late]
constexpr double kFlags = 0.1, kFar = 0.001;
// Number of images that must agree again before the flag ends. [tuned: depth late]
constexpr int kDistrust = 3;

}  // namespace

void EncoderDepthCheck::Examine(const LoadSample& sample, Findings* findings) noexcept {
  if (!sample.tool) return;
  const ToolReading& tool = *sample.tool;
  const SurfaceLoad& load = sample.load;
  const double moved = std::abs(tool.depth - std::exchange(last_depth_, tool.depth));
  if (!IsForceKnown(load.validity)) return;
  const bool seen = load.force != 0;
  const double way = tool.lag * moved;
  const double apart = way + kParts * sample.size;
  const double beside = (load.p_O - tool.p_O).norm() - kNear * sample.size;
  if (seen && beside > 0) {
    if (tool.depth > apart && beside > kPlaceSigmas * load.sigma_place) {
      findings->Fail(FailedCheck::kArm,
                     "the manipulator is in contact where the surface is not indented: a camera or "
                     "the manipulator has moved");
    }
    return;
  }
  const double depth = seen ? std::max(0.0, load.depth) : 0;
  // A larger difference is an error of the camera or of the encoders.
  const double beyond = std::abs(tool.depth - depth) - apart - kShare * std::max(tool.depth, depth);
  const double sigma = tool.stiffness * std::max(beyond, 0.0);
  distrust_ = sigma < kFlags * std::abs(load.force) || beyond < kFar * sample.size
                  ? std::max(0, distrust_ - 1)
                  : kDistrust;
  if (distrust_ > 0) {
    findings->Fail(FailedCheck::kInstants,
                   "the surface is less deep than the tip by the encoders: image latency, or a "
                   "camera or the manipulator has moved");
  }
  // A lag that is too small to be flagged is an error all the same.
  const double widening = tool.stiffness * std::max(beyond + way, 0.0);
  if (std::isfinite(widening)) findings->Widen(widening);
}

}  // namespace palpate
