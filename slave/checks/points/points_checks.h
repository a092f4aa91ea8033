// The checks of a stereo pair or depth camera: of the points, before a load is fitted to them.
#pragma once

#include <optional>

#include "shared/mesh/solid_mesh.h"
#include "slave/checks/check.h"
#include "slave/checks/points/points_sample.h"
#include "slave/checks/points/rest_surface.h"
#include "slave/scene/scene.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

// `rig` is not used with depth images. `surface_O`: the body that is compared with the surface at
// rest; empty: none. `rest` gets the comparison and must outlive the checks.
Checks<PointsSample> MakePointsChecks(const Scene& scene, const StereoRig& rig,
                                      const SurfaceMesh& surface_O,
                                      std::optional<RestSurface>* rest);

}  // namespace palpate
