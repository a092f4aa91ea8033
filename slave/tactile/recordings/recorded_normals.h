// Recordings of a fingertip with measured contact normals.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "slave/tactile/recordings/data_argument.h"
#include "slave/tactile/rest_values.h"

namespace palpate {

// The samples in contact, in their order.
struct ContactNormals {
  std::vector<TactileSignals> change;    // counts minus rest
  std::vector<Eigen::Vector3d> normals;  // unit, as in the file
  double contact_pdc = 0;                // contact is above it [counts]
};

// Columns nx, ny, nz beside a finger's electrodes and pdc. Contact: pdc above `contact_pdc`; where
// that is not given, above its level at rest (the second percentile) by a twentieth of its range.
// Rest values: medians of all rows without contact, the slice's or not. Throws std::runtime_error
// naming file (and line) and what is wrong with it.
ContactNormals ReadContactNormals(const DataArgument& data, const std::string& finger,
                                  std::optional<double> contact_pdc);

}  // namespace palpate
