// LoadSample is the input of the checks of a load, which run after those of its fit. Frame O.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "slave/checks/load/surface_load.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// The tip according to the encoders.
struct ToolReading {
  Eigen::Vector3d p_O{0, 0, 0};  // nearest point of the surface at rest [m]
  double depth = 0;              // below it, >= 0 [m]
  double lag = 0;                // largest time between reading and images [image periods]
  double stiffness = 0;          // of the object there at this depth, or at the load's [N/m]
};

struct LoadSample {
  const SurfaceObservation& seen;
  const SurfaceLoad& load;
  std::optional<ToolReading> tool;  // nullopt: the images do not show it
  double size = 0;                  // larger side of the object [m]
};

}  // namespace palpate
