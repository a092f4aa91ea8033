// The error of linearity outside the zones, in the force of each contact: a dual-weighted residual
// (Becker and Rannacher, Acta Numerica 10, 2001). With the residual r = f_neo-Hooke(u) -
// f_linear(u) of the tetrahedra outside all zones at the composed displacement u, and the
// displacement z by a unit motion of a contact,
//
//   true force - force = z . r + O(r^2)
//
// The dual solution z is known: it is the contact's own response. Nothing is fitted.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/zone/zone_place.h"

namespace palpate {

class OutsideError {
 public:
  struct Source {
    const ZonePlace* place = nullptr;
    const Eigen::MatrixXd* dual = nullptr;  // modes by a unit motion of the contact along each axis
  };
  // Keeps no reference. Leaves out tetrahedra that the duals hardly strain. O(tetrahedra modes).
  OutsideError(const ZonePlaces& places, std::span<const Source> sources);

  // Composes the displacement by the amplitudes of every source's modes. Call Compose for each
  // source after Clear, then FindResidual, then Work. None allocates.
  void Clear() noexcept { u_.setZero(); }
  void Compose(int source, const Eigen::VectorXd& amplitudes) noexcept;
  void FindResidual() noexcept;
  // Work of the residual on the modes of a source.
  void Work(int source, Eigen::VectorXd* work) noexcept;

 private:
  std::vector<Eigen::MatrixXd> far_;  // per source, on the nodes of these tetrahedra
  std::optional<NeoHookeanTets> outside_, shared_;
  Eigen::VectorXd u_, residual_, linear_;
};

}  // namespace palpate
