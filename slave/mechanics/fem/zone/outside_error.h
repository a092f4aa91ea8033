// The error of linearity outside the zones, in the force of one contact: a dual-weighted residual
// (Becker and Rannacher, Acta Numerica 10, 2001). With the nonlinear force r of the tetrahedra
// outside all zones at the displacement u, and the displacement z by a unit motion of the contact,
//
//   true force - force = z . r + O(r^2)
//
// The dual solution z is known: it is the contact's own response. Nothing is fitted. Far away the
// strains of u and z fall with the square of the distance, so that a volume there counts by the
// distance to the power of -6; that part is extrapolated.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "slave/mechanics/fem/zone/near/transfer.h"
#include "slave/mechanics/fem/zone/zone_part.h"

namespace palpate {

class OutsideError {
 public:
  // Where a contact lies: tetrahedra up to `reach` from it count. Lengths in units.
  struct Region {
    Eigen::Vector3d centre{0, 0, 0};
    double radius = 0, reach = 0;  // of the zone; of what is looked at
  };
  // For parts[own]. `taken`: tetrahedra of the zones. Keeps references to the parts.
  OutsideError(NearGreen& green, const SolidMesh& mesh, double nu, const std::vector<char>& taken,
               std::span<ZonePart* const> parts, std::size_t own, const Region& region);

  // One of the pieces of an estimate of the present state of the parts, each about as long. True:
  // it was the last one. Does not allocate.
  bool Advance() noexcept;
  // The next piece is the first.
  void Restart() { piece_ = 0; }
  // True value minus value, of the force or of a load's mean displacement, to first order.
  [[nodiscard]] const Eigen::Vector3d& error() const { return error_; }
  // By how much a correction of the displacement outside changes it at most.
  [[nodiscard]] double second_order() const { return second_; }
  [[nodiscard]] int size() const { return tets_ ? tets_->size() : 0; }

 private:
  void AddDisplacement(std::size_t piece) noexcept;
  void FindResidual(Eigen::Vector3d* error) noexcept;
  void Correct() noexcept;
  void FindChange() noexcept;
  void FindDual() noexcept;
  struct Source {
    ZonePart* part = nullptr;
    Transfer transfer;     // from its samples to the nodes
    Eigen::VectorXd load;  // on its samples
  };

  ZonePart& own_;
  std::optional<NeoHookeanTets> tets_;
  std::vector<Source> others_;
  Eigen::MatrixXf green_;  // of the nodes by the own samples
  Eigen::MatrixXf rim_;    // of the first nodes, next to the zone, by all nodes of the zone
  Eigen::LLT<Eigen::MatrixXd> between_;  // compliance of the samples
  double scale_ = 1;
  std::size_t piece_ = 0;  // the next one
  Eigen::VectorXd u_, residual_, work_, held_, load_;
  Eigen::VectorXf nodes_f_, load_f_, rim_f_, zone_f_;
  Eigen::MatrixXd dual_;    // displacement of the nodes
  Eigen::VectorXd before_;  // residual without the correction
  Eigen::Vector3d first_ = Eigen::Vector3d::Zero(), error_ = first_;
  double second_ = 0;
};

}  // namespace palpate
