// The pressure for given displacements, if it is an unknown and the law is not linear: volume
// change divided by the compressibility, as the mean weighted by each vertex's shape function.
#pragma once

#include <Eigen/Core>

#include "slave/mechanics/fem/solid/elastic_body.h"
#include "slave/mechanics/fem/solid/sparse_system.h"
#include "slave/mechanics/linear/sparse_ldlt.h"

namespace palpate {

class PressureUpdate {
 public:
  // Stores references to its arguments.
  PressureUpdate(const BlockLayout& layout, const ElasticBody& body);

  // Sets the pressures of x by its displacements.
  void Update(Eigen::VectorXd* x);

 private:
  const BlockLayout& layout_;
  const ElasticBody& body_;
  SparseMatrix mass_;
  SparseLdlt<double> solver_;
  Eigen::VectorXd change_, pressure_;
};

}  // namespace palpate
