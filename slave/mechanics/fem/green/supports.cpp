#include "slave/mechanics/fem/green/supports.h"

#include <cstddef>
#include <numeric>
#include <stdexcept>
#include <string>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr double kFixesMotion = 1e-10;  // smallest eigenvalue of the motions' Gram matrix

// The part that each node belongs to, named by one of its nodes.
class Parts {
 public:
  explicit Parts(const SolidMesh& mesh) : parent_(mesh.nodes.size()) {
    std::iota(parent_.begin(), parent_.end(), 0);
    for (const auto& tet : mesh.tets) {
      for (const int node : tet) parent_[Index(Of(node))] = Of(tet[0]);
    }
  }
  int Of(int node) {
    while (parent_[Index(node)] != node) {
      parent_[Index(node)] = parent_[Index(parent_[Index(node)])];
      node = parent_[Index(node)];
    }
    return node;
  }

 private:
  std::vector<int> parent_;
};

struct Extent {
  Eigen::Vector3d low, high;
  int nodes = 0;
};

}  // namespace

void RequireSupported(const SolidMesh& mesh, const std::vector<std::array<bool, 3>>& held) {
  const int count = static_cast<int>(mesh.nodes.size());
  Parts parts(mesh);
  std::vector<Extent> extent(mesh.nodes.size());
  for (int n = 0; n < count; ++n) {
    const auto& p = mesh.nodes[Index(n)];
    Extent& e = extent[Index(parts.Of(n))];
    e.low = e.nodes == 0 ? p : Eigen::Vector3d(e.low.cwiseMin(p));
    e.high = e.nodes == 0 ? p : Eigen::Vector3d(e.high.cwiseMax(p));
    ++e.nodes;
  }
  std::vector<Matrix6d> gram(mesh.nodes.size(), Matrix6d::Zero());
  for (int n = 0; n < count; ++n) {
    const int part = parts.Of(n);
    const Extent& e = extent[Index(part)];
    const Eigen::Vector3d r =
        (mesh.nodes[Index(n)] - 0.5 * (e.low + e.high)) / (e.high - e.low).maxCoeff();
    for (int c = 0; c < 3; ++c) {
      if (!held[Index(n)][Index(c)]) continue;
      Eigen::Matrix<double, 6, 1> mode;
      mode << Eigen::Vector3d::Unit(c), r.cross(Eigen::Vector3d::Unit(c));
      gram[Index(part)] += mode * mode.transpose();
    }
  }
  for (int n = 0; n < count; ++n) {
    if (parts.Of(n) != n || extent[Index(n)].nodes < 4) continue;  // a node in no tetrahedron
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(gram[Index(n)], Eigen::EigenvaluesOnly);
    if (eigen.eigenvalues()[0] > kFixesMotion) continue;
    throw std::invalid_argument(
        "object.fixed: fem-green needs supports that hold the body: accepted is what fixes all six "
        "rigid motions of every part; the part with node " +
        std::to_string(n) + " is free to move");
  }
}

}  // namespace palpate
