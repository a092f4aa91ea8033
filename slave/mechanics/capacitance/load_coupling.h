// What loads do to the places of contacts, to their own and to each other's. Nondimensional.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/capacitance/compliance.h"
#include "slave/mechanics/capacitance/contact_set.h"
#include "slave/mechanics/linear/dense_kernels.h"

namespace palpate {

class LoadCoupling {
 public:
  explicit LoadCoupling(Compliance& compliance) : compliance_(compliance) {}

  // False: a column is not to be had. O(unknowns times loaded places). Memory only grows.
  bool Fill(const ContactSet& set, int padded_rows);

  // Displacement of the unknown components by a unit force `c` of a load: padded, zeros behind.
  [[nodiscard]] const double* unknowns_by(int load, int c) const {
    return by_.get() + (3 * load + c) * stride_;
  }
  // Mean displacement `c` of a load's places by unit unknown components.
  [[nodiscard]] const double* load_by_unknowns(int load, int c) const {
    return (compliance_.symmetric() ? by_ : at_).get() + (3 * load + c) * stride_;
  }
  // Mean displacement of a load's places by another load's unit force.
  [[nodiscard]] const Eigen::Matrix3d& between(int at, int by) const {
    return between_[static_cast<std::size_t>(at * loads_ + by)];
  }

 private:
  Compliance& compliance_;
  int loads_ = 0;
  long stride_ = 0;
  std::size_t room_ = 0;
  AlignedArray by_, at_;  // 3 rows per load
  std::vector<Eigen::Matrix3d> between_;
};

}  // namespace palpate
