// Meshes of the true body, finer where fingers come, and none that an estimator uses.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "shared/scene/scene.h"

namespace palpate::site {

// How fine. Edges near the fingers [m]; elsewhere they grow with the distance.
struct SiteResolution {
  double edge = 1.75e-3;          // of boxes, where fingers touch
  double fine_reach = 5e-3;       // from there as fine [m]
  double growth = 0.5;            // of the edge per distance beyond [-]
  std::size_t most_tets = 20000;  // mesh files are refined at most twice, within this
};

// Points from 0 to `length` as dense as `resolution` says around `focuses`, each of which is met.
std::vector<double> GradedAxis(double length, std::span<const double> focuses,
                               const SiteResolution& resolution);

// A box over three axes' points, cut like MeshBox.
SolidMesh MeshGradedBox(const std::array<std::vector<double>, 3>& axes);

// A mesh file's own tetrahedra. Throws std::invalid_argument: no volume, an unusable file.
SolidMesh OwnMesh(const Geometry& geometry);

// The mesh for a volume whose fingers touch near `focuses_O`: a graded box, or a file's own mesh
// refined. Throws as OwnMesh.
SolidMesh MeshForFingers(const Geometry& geometry, std::span<const Eigen::Vector3d> focuses_O,
                         const SiteResolution& resolution);

}  // namespace palpate::site
