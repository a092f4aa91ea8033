#include "slave/pipeline/press/patch_compliance.h"

#include <algorithm>
#include <cmath>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

// Half the mean edge: how softly a patch ends, so that it changes steadily as it moves.
double EdgeSoftness(const SurfaceMesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      sum += (mesh.nodes[Index(t[k])] - mesh.nodes[Index(t[(k + 1) % 3])]).norm();
    }
  }
  return sum / (6 * static_cast<double>(mesh.triangles.size()));
}

}  // namespace

PatchCompliance::PatchCompliance(const InflatedMembrane& membrane, double diameter,
                                 bool steady_air) {
  const SurfaceMesh& mesh = membrane.surface();
  const auto nodes = static_cast<Eigen::Index>(mesh.nodes.size());
  const Eigen::MatrixXd compliance = membrane.NormalCompliance(steady_air);
  by_pressure_ = compliance * Eigen::Map<const Eigen::VectorXd>(membrane.areas().data(), nodes);
  shares_.resize(mesh.nodes.size());
  by_patch_ = Eigen::MatrixXd::Zero(nodes, nodes);
  const double softness = EdgeSoftness(mesh);
  for (int j = 0; j < static_cast<int>(nodes); ++j) {
    if (membrane.IsHeld(j)) continue;
    const auto at = Index(j);
    std::vector<Share>& shares = shares_[at];
    // Pressures act along each node's own normal: what counts is their sum along the patch's.
    double sum = 0;
    for (int i = 0; i < static_cast<int>(nodes); ++i) {
      const auto node = Index(i);
      const double r = (mesh.nodes[node] - mesh.nodes[at]).norm();
      const double inside = std::clamp(0.5 + (diameter / 2 - r) / (2 * softness), 0.0, 1.0);
      const double facing = membrane.normals()[node].dot(membrane.normals()[at]);
      if (i != j && (inside == 0 || facing <= 0)) continue;
      const double push = std::max(inside, i == j ? 1e-3 : 0) * membrane.areas()[node];
      shares.push_back({i, push});
      sum += push * facing;
    }
    for (Share& share : shares) {
      share.share /= sum;
      by_patch_.col(j) -= share.share * compliance.col(share.node);
    }
  }
}

double PatchCompliance::GiveAt(const std::array<int, 3>& triangle,
                               const Eigen::Vector3d& weights) const noexcept {
  double give = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      const double weight = weights[static_cast<int>(a)] * weights[static_cast<int>(b)];
      for (const Share& share : shares(triangle[b])) {
        give -= weight * share.share * by_patch_(share.node, triangle[a]);
      }
    }
  }
  return give;
}

}  // namespace palpate
