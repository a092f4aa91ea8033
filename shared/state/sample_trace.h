// Times of a sample in the stages of the slave, slave's clock.
#pragma once

#include <cstdint>

#include "shared/state/clock.h"

namespace palpate {

struct SampleTrace {
  std::uint64_t sample = 0;  // its number at the source
  Time sensed_at{};          // as in the states of this sample
  Time acquired_at{};        // the slave has the sample
  Time processed_at{};       // vision or tactile processing is done
  Time solved_at{};          // the model is solved
};

}  // namespace palpate
