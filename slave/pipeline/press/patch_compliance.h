// What a unit force, spread evenly over a round patch, does to a membrane.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/membrane/inflated_membrane.h"

namespace palpate {

// Deflections are along the nodes' outward normals [m]; the force is one newton inward. Patches are
// centred at nodes; between them they are mixed by barycentric weights.
class PatchCompliance {
 public:
  // `diameter` of the patch [m]. `steady_air`: the pressure does not answer. O(nodes^2).
  PatchCompliance(const InflatedMembrane& membrane, double diameter, bool steady_air);

  // nodes x nodes [m/N]: column j by a patch at node j, zero at held nodes.
  [[nodiscard]] const Eigen::MatrixXd& by_patch() const { return by_patch_; }
  // By one pascal behind the whole membrane [m/Pa].
  [[nodiscard]] const Eigen::VectorXd& by_pressure() const { return by_pressure_; }
  // The newton of a patch at `node`, shared out over the nodes under it; sums to one.
  struct Share {
    int node = 0;
    double share = 0;
  };
  [[nodiscard]] const std::vector<Share>& shares(int node) const {
    return shares_[static_cast<std::size_t>(node)];
  }
  // Mean way inward of a patch there under its own newton [m/N]; `triangle` names the nodes.
  [[nodiscard]] double GiveAt(const std::array<int, 3>& triangle,
                              const Eigen::Vector3d& weights) const noexcept;

 private:
  std::vector<std::vector<Share>> shares_;
  Eigen::MatrixXd by_patch_;
  Eigen::VectorXd by_pressure_;
};

}  // namespace palpate
