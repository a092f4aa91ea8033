// What the loads of one zone do to the nodes of another one in the same linear body. The forces of
// its contact act exactly. The loads of its tetrahedra act as forces on a few samples: they balance
// each other within the zone, so that their displacement elsewhere is small and smooth.
#pragma once

#include <Eigen/Core>

#include "slave/mechanics/fem/zone/transfer.h"
#include "slave/mechanics/fem/zone/zone_part.h"

namespace palpate {

class ZoneCoupling {
 public:
  // Keeps a reference to `from`.
  ZoneCoupling(NearGreen& green, const ZonePart& to, const ZonePart& from);

  // Adds the displacement of the points of `to`, or of the nodes of its zone, by the present forces
  // on the points of `from`. None of these allocates.
  void AddAtPoints(Eigen::VectorXf* at) const noexcept;
  void AddAtNodes(Eigen::VectorXf* u) const noexcept;
  // Adds the displacement of the samples of `to` by forces on the samples of `from`.
  void AddAtSamples(const Eigen::VectorXd& forces, Eigen::VectorXd* samples) noexcept;
  // Of the force of `to` by a force of `from`, as it is distributed when that contact moves; both
  // held otherwise.
  [[nodiscard]] double Gain(const ZonePart& to) const;

 private:
  const ZonePart* from_;
  Eigen::MatrixXf columns_, at_points_;  // of the nodes, of the points
  Transfer samples_;
};

}  // namespace palpate
