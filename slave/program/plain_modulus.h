// A modulus and a force in words that a person can check without a table.
#pragma once

#include <string>

namespace palpate {

// Returns the known material whose Young's modulus is nearest by ratio to this one [Pa] > 0, such
// as "silicone of Shore 00-30".
std::string StiffAs(double young_modulus);
// "0.27 N, the weight of 28 g".
std::string ForceText(double newtons);
// One sentence for a Young's modulus [Pa]: a known material as stiff, and the force on a cube of
// 10 mm that two plates compress by 1 mm.
std::string ModulusText(double young_modulus);

}  // namespace palpate
