// FitSample is the input of the checks of a fitted load. Frame O.
#pragma once

#include <cmath>
#include <string_view>
#include <vector>

#include "slave/checks/load/surface_load.h"
#include "slave/mechanics/plate/fit/load_fit.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// A nuisance parameter of a fit, zero if all is well: Wald's test shows whether it is.
struct NuisanceParameter {
  double value = 0, sigma = 0;
  double tolerance = 0;  // fraction of the value that the model's error may cause

  [[nodiscard]] bool IsSignificant(double sigmas) const noexcept {
    return std::abs(value) > sigmas * sigma + tolerance;
  }
};

// PlateFit is the result of the fit of a load on a flat membrane.
struct PlateFit {
  LoadFit load;
  int points = 0;    // points on the plate, visible and selected
  int left_out = 0;  // number of excluded outliers
  // The rim or the cameras have moved since rest. The load does not include it: a motion of the
  // cameras within limits is compensated.
  bool moved = false, compensated = false;
  // Displacement along the plate that is proportional to the distance from the points' centre, rms
  // [m].
  NuisanceParameter growth;
  // Tension at rest beyond the scene's [N/m], the model's error as its tolerance, and the change of
  // the load's force per change of the tension [N / (N/m)]; sigma 0: not identified.
  NuisanceParameter tension;
  double force_per_tension = 0;
  double sigma = 0;    // of a point along z, rms [m]
  double deepest = 0;  // largest fitted deflection [m]
};

struct FitSample {
  const std::vector<SurfacePoint>& points_O;
  const SurfaceLoad& load;        // without the results of these checks
  int points = 0, left_out = 0;   // number of points in the fit, and number of outliers among them
  int freedom = 0;                // degrees of freedom of the residuals
  double sigma = 0;               // of a point's residual [m]
  double deepest = 0;             // largest deflection [m]
  std::string_view beyond_range;  // why the model's answer is extrapolated; empty: it is not

  const PlateFit* plate = nullptr;  // of a flat membrane
  double rest_residual = 0;         // SurfaceLoad::residual without contact; 0: unknown

  // Returns the fraction of the squared residuals that the points also have without contact; 1:
  // unknown.
  [[nodiscard]] double NoiseShare() const noexcept {
    const double ratio = rest_residual / load.residual;
    return rest_residual > 0 && ratio < 1 ? ratio * ratio : 1;
  }
};

}  // namespace palpate
