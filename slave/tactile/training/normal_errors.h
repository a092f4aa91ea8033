// How good found contact normals are.
#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "slave/tactile/localise/localiser.h"
#include "slave/tactile/rest_values.h"

namespace palpate {

struct NormalErrors {
  std::size_t found = 0;  // samples with a place; the others are left out
  double median = 0;      // angle between found and measured normals [rad]
  // The same after the one rotation of all found normals that is best: what is left where the
  // measurement's axes are not quite the fingertip's.
  double aligned_median = 0;
};

// `normals_F`: measured, unit, one per sample. No sample with a place: found is 0.
NormalErrors CompareNormals(const Localiser& localiser, std::span<const TactileSignals> changes,
                            std::span<const Eigen::Vector3d> normals_F);

}  // namespace palpate
