// Where a window seen by one camera is in the other: along the line of places its ray may have.
#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "slave/vision/stereo/rig.h"
#include "slave/vision/texture/picture_pyramid.h"
#include "slave/vision/texture/window_template.h"

namespace palpate {

struct EpipolarOptions {
  double least_correlation = 0.7;  // at the coarse level
  double least_margin = 0.03;      // over the best elsewhere: what looks alike twice is refused
};

// `seen` in the picture of `from`; its window, as `window` has it on `level`, is looked for in
// `picture`, taken by `to`, from infinity to as near as both cameras can see; X_TF: p_to = X_TF
// p_from. nullopt: not there, or there twice. Real-time safe.
std::optional<WindowWarp> SearchEpipolar(const Lens& from, const Lens& to,
                                         const Eigen::Isometry3d& X_TF, const WindowWarp& seen,
                                         WindowTemplate& window, const PicturePyramid& picture,
                                         int level, const EpipolarOptions& options) noexcept;

}  // namespace palpate
