// A modulus and a force in words that a person can check without a table.
#pragma once

#include <string>

namespace palpate {

// A familiar thing of about this Young's modulus [Pa]: "a gummy bear".
std::string StiffAs(double young_modulus);
// "0.27 N, the weight of 28 g".
std::string ForceInPlainWords(double newtons);
// One sentence: a thing as stiff, and the force of a cube of 10 mm, pressed by 1 mm between two
// plates. [Pa]
std::string InPlainWords(double young_modulus);

}  // namespace palpate
