// The values that no input may have.
#pragma once

#include <limits>

namespace palpate {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInf = std::numeric_limits<double>::infinity();

}  // namespace palpate
