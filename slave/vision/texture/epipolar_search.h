// Where a window seen by one camera is in the other: along the line of places its ray may have.
#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "slave/vision/stereo/rig.h"
#include "slave/vision/texture/ssd_tracker.h"

namespace palpate {

struct EpipolarOptions {
  double near = 0.08, far = 1.0;   // depths searched [m], 0 < near < far
  double least_correlation = 0.7;  // at the coarse level
  double least_margin = 0.03;      // over the best elsewhere: what looks alike twice is refused
};

// `seen` in the picture of `from`, its window `i` looked for in the last picture of `tracker`,
// taken by `to`; X_TF: p_to = X_TF p_from. nullopt: not there, or there twice. Real-time safe.
std::optional<WindowWarp> SearchEpipolar(const Lens& from, const Lens& to,
                                         const Eigen::Isometry3d& X_TF, const WindowWarp& seen,
                                         SsdTracker& tracker, std::size_t i,
                                         const EpipolarOptions& options) noexcept;

}  // namespace palpate
