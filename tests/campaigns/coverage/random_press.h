// Random presses, one kind for each sense: object, tool, cameras and motion differ from those of
// all scenes. The inputs of the sense differ from the truth by the tolerances that the scene
// states.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "tests/campaigns/robustness/case.h"
#include "tests/campaigns/robustness/stage.h"

namespace palpate::coverage {

struct RandomPress {
  std::unique_ptr<robustness::Stage> stage;
  robustness::Alteration alteration;  // the sense is given the nominal modulus
  double modulus_error = 0;           // true over nominal modulus, less 1 [-]
};

// Draws press `number` of a series. `sense`: camera, pairs or fingertips; throws
// std::invalid_argument for any other. The moduli of a series are spread evenly over their
// distribution; everything else is drawn independently.
RandomPress DrawPress(const std::string& sense, std::uint32_t seed, int number);

}  // namespace palpate::coverage
