// What the checks of a fitted load get. Frame O.
#pragma once

#include <string_view>
#include <vector>

#include "slave/checks/load/plate_fit.h"
#include "slave/checks/load/surface_load.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

struct FitSample {
  const std::vector<SurfacePoint>& points_O;
  const SurfaceLoad& load;        // without the results of these checks
  int points = 0, left_out = 0;   // that take part; of them, those that contradict the others
  double off = 0;                 // rms of (measured - fitted) [m]
  std::string_view beyond_range;  // why the model's answer is extrapolated; empty: it is not

  const PlateFit* plate = nullptr;  // of a flat membrane
  double rest_square = 0;           // mean of off^2 without contact [m^2]; 0: unknown

  // Share of off^2 that the points have without contact as well; 1: unknown.
  [[nodiscard]] double NoiseShare() const noexcept {
    return rest_square > 0 && off * off > rest_square ? rest_square / (off * off) : 1;
  }
};

}  // namespace palpate
