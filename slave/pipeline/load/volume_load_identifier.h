// Volumes under the eyes: `fem`, `fem-hyperelastic`, `fem-green`, `bem3d`.
#pragma once

#include <memory>
#include <vector>

#include "slave/pipeline/load/load_identifier.h"
#include "slave/scene/scene.h"

namespace palpate {

// One load along the surface's normal, by least squares in all three components of all visible
// points. Its place is looked for over all nodes of the surface, then within the triangles there,
// where three nodal forces of one sign, a linear problem, are one load between the nodes. The
// search uses the body's Green's functions at rest; where the model is not linear the force is
// refined through the model itself. The first observation costs three solves per point.
// `width`: diameter of the load [m]. Throws std::invalid_argument naming the key: no volume, a
// model that moves in time; see MeshObject, MakeModel.
std::unique_ptr<LoadIdentifier> MakeVolumeLoadIdentifier(const Scene& scene, double width);

}  // namespace palpate
