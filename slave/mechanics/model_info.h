// Properties of a deformation model, as the scene's description and `study` report them.
#pragma once

#include <cstddef>
#include <string>

namespace palpate {

// Properties of a model.
struct ModelInfo {
  std::string kind;  // bem2d, ...
  std::size_t dof = 0;
  int elements = 0;
  double precompute_s = 0;       // measured [s]
  std::size_t memory_bytes = 0;  // kept after precompute
  double condition = 0;  // estimated condition number of the reference system [-]; 0: not known
  double range = 0;      // largest |displacement| / larger side before `extrapolated` [-]
  double step = 0;       // of time, one per Respond [s]; 0: static
  double update_us = 0;  // expected for one moved contact, measured after precompute; 0: not known
  std::string remark;    // remark for the user about this choice, one clause; may be empty
};

}  // namespace palpate
