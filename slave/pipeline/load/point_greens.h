// How a body's seen points move under a load on any node of its surface: Green's functions by
// reciprocity, from loads on the points.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/contact/surface_contact.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/footprint/contact_footprint.h"

namespace palpate {

// Small strain, at rest. Frame O.
class PointGreens {
 public:
  // `load`: size of a force so small that the model's answer is linear [N]; `patch`: diameter of
  // the discs over which a node's load is spread [m].
  PointGreens(const SurfaceMesh& surface, double load, double patch);

  // Three Responds per point whose place at rest is not that of the last call; else nothing. A
  // point that the model does not answer for: false from Knows(). Allocates where points are new.
  void See(DeformationModel& model, const SurfaceContact& contact,
           const std::vector<Eigen::Vector3d>& p_O_rest);
  [[nodiscard]] bool Knows(std::size_t point) const { return known_[point]; }
  [[nodiscard]] const std::vector<int>& nodes() const { return nodes_; }  // that can be loaded
  // Column per node of nodes(), three rows per point: displacement [m] of the point along x, y and
  // z by a force of 1 N on the node along its axis `axis`.
  [[nodiscard]] const Eigen::MatrixXd& by(int axis) const {
    return by_[static_cast<std::size_t>(axis)];
  }
  // Of the node in nodes().
  [[nodiscard]] int IndexOf(int node) const { return index_[static_cast<std::size_t>(node)]; }

 private:
  void FindPatches(double patch);
  bool Load(DeformationModel& model, const Contact& contact, Eigen::Index row);

  const SurfaceMesh& surface_;
  double load_;
  std::vector<int> nodes_, index_;
  std::vector<std::vector<PlaceWeight>> patches_;  // nodes that share a node's load
  std::vector<Eigen::Vector3d> rest_, field_;
  std::vector<bool> known_;
  std::array<Eigen::MatrixXd, 3> by_;
};

}  // namespace palpate
