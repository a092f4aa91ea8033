// A smooth displacement field on many nodes from its values on a few of them, and forces on many
// nodes as forces on these few: radial basis functions |x| and linear fields, so that translations,
// rotations, strains, resultants and moments are exact (Buhmann, Radial Basis Functions, 2003).
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/zone/near/near_green.h"

namespace palpate {

class FieldSamples {
 public:
  std::vector<int> nodes;   // of the mesh, or numbers of anchors
  Eigen::MatrixXf weights;  // of the targets by the samples

  [[nodiscard]] int unknowns() const { return 3 * static_cast<int>(nodes.size()); }
  // values += interpolation of `sampled`; sampled = adjoint of it. Three numbers per node; neither
  // allocates after the first time.
  void AddField(const Eigen::VectorXd& sampled, Eigen::VectorXd* values) noexcept;
  void SampleForces(const Eigen::VectorXd& forces, Eigen::VectorXd* sampled) noexcept;

 private:
  Eigen::VectorXf few_, many_;  // room
};

// Samples that are the anchors nearest to the nodes, for fields whose sources are far away.
FieldSamples SamplesAtAnchors(const NearGreen& green, std::span<const int> nodes);

// Weights of `targets` by `samples`, positions in the same units.
Eigen::MatrixXf SampleWeights(std::span<const Eigen::Vector3d> samples,
                              std::span<const Eigen::Vector3d> targets);

}  // namespace palpate
