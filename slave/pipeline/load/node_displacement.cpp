#include "slave/pipeline/load/node_displacement.h"

#include <algorithm>
#include <utility>

namespace palpate {

void NodeDisplacement(DeformationModel& model, const SurfaceMesh& surface,
                      std::vector<Eigen::Vector3d>* u_O) {
  model.BoundaryDisplacement(u_O);
  if (u_O->size() == surface.nodes.size()) return;
  const std::vector<Eigen::Vector3d> of_triangle = std::move(*u_O);
  u_O->assign(surface.nodes.size(), Eigen::Vector3d::Zero());
  std::vector<int> count(surface.nodes.size(), 0);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    for (const int node : surface.triangles[t]) {
      (*u_O)[static_cast<std::size_t>(node)] += of_triangle[t];
      ++count[static_cast<std::size_t>(node)];
    }
  }
  for (std::size_t i = 0; i < count.size(); ++i) (*u_O)[i] /= std::max(count[i], 1);
}

}  // namespace palpate
