// What the loads of one zone do to the nodes of another one in the same linear body. The forces of
// its contact act exactly on the other one's points, and on its other nodes where the zones are
// near each other. Else, and by the loads of the tetrahedra, which balance each other, the
// displacement is smooth: it is found at a few samples.
#pragma once

#include <Eigen/Core>

#include "slave/mechanics/fem/zone/near/transfer.h"
#include "slave/mechanics/fem/zone/zone_part.h"

namespace palpate {

class ZoneCoupling {
 public:
  // Keeps a reference to `from`.
  ZoneCoupling(NearGreen& green, const ZonePart& to, const ZonePart& from, bool near);

  // Adds the displacement by the present forces on the points of `from`: of the points of `to`; of
  // the nodes of its zone or, of one that is not near, of its samples. None of these allocates.
  void AddAtPoints(Eigen::VectorXf* at) const noexcept { Add(at_points_, at); }
  void AddAtNodes(Eigen::VectorXf* nodes, Eigen::VectorXf* samples) const noexcept {
    Add(columns_, near_ ? nodes : samples);
  }
  // Adds the displacement of the samples of `to` by forces on the samples of `from`.
  void AddAtSamples(const Eigen::VectorXd& forces, Eigen::VectorXd* samples) noexcept {
    samples_.Add(forces, samples);
  }
  // For the force of `to` by a force of `from`, as it is distributed when that contact moves; both
  // held otherwise.
  [[nodiscard]] double Gain(const ZonePart& to) const;

 private:
  void Add(const Eigen::MatrixXf& columns, Eigen::VectorXf* u) const noexcept;

  const ZonePart* from_;
  bool near_;
  Eigen::MatrixXf columns_, at_points_;  // of the nodes or samples, of the points
  Transfer samples_;
};

}  // namespace palpate
