// Meshes of the true body, finer where fingers come, and none that an estimator uses.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/scene/scene.h"
#include "slave/site/fingertips/site_resolution.h"

namespace palpate::site {

// Points from 0 to `length`, as dense as `resolution` says around `focuses`, which they meet where
// those lie inside, as they do `others`. `cells`: exactly so many, 0: as many as it takes. Fewer
// than the places to be met: as many as those.
struct AxisWishes {
  double length = 0;  // [m], > 0
  std::vector<double> focuses, others;
};
std::vector<double> GradedAxis(const AxisWishes& axis, const SiteResolution& resolution,
                               int cells = 0);

// A box over three axes' points, cut like MeshBox.
SolidMesh MeshGradedBox(const std::array<std::vector<double>, 3>& axes);

// A mesh file's own tetrahedra. Throws std::invalid_argument: no volume, an unusable file.
SolidMesh OwnMesh(const Geometry& geometry);
// Refined at most twice.
SolidMesh RefinedWithin(SolidMesh mesh, std::size_t most_tets);

}  // namespace palpate::site
