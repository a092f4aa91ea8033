// A place that can be touched: a zone, the rest of the body around it, and how the body moves far
// from it.
//
// What the border does to the rest is described by a few modes: those motions of the border that
// loads on the zone's surface cause, ordered by their elastic energy in the rest (proper orthogonal
// decomposition in the norm of S_rest). They give the displacement of the whole linear body by
// `far` and with it the effect of one contact on another, and the error of linearity outside.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/fem/zone/linear_rest.h"
#include "slave/mechanics/fem/zone/zone_solver.h"

namespace palpate {

struct ZonePlace {
  ZoneBody body;
  Eigen::MatrixXd to_modes;  // from displacements of the border to amplitudes of modes
  Eigen::MatrixXf far;       // displacement of every node of the mesh by each mode
};

class ZonePlaces {
 public:
  // `modes`: at most so many per place. Throws: see LinearRest.
  ZonePlaces(const SolidMesh& mesh, const HeldNodes& held, double nu, int modes);

  // A zone of `radius` [m] around a point of the surface, and all elements at `touched`. Throws:
  // see LinearRest::Condense; std::runtime_error if it cannot be factored.
  ZonePlace Make(const Eigen::Vector3d& centre_O, double radius, const std::vector<int>& touched);

  [[nodiscard]] LinearRest& rest() { return rest_; }
  // In units of length.
  [[nodiscard]] const std::vector<Eigen::Vector3d>& positions() const { return positions_; }
  [[nodiscard]] const SolidMesh& mesh() const { return mesh_; }
  [[nodiscard]] double nu() const { return nu_; }

 private:
  void FindModes(ZonePlace* place);

  const SolidMesh& mesh_;
  double nu_;
  int modes_;
  LinearRest rest_;
  ZoneFinder finder_;
  std::vector<Eigen::Vector3d> positions_;
  std::vector<char> on_surface_;  // per node
};

}  // namespace palpate
