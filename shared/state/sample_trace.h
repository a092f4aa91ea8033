// When a sample came through the slave, stage by stage. Slave's clock.
#pragma once

#include <cstdint>

#include "shared/state/clock.h"

namespace palpate {

struct SampleTrace {
  std::uint64_t sample = 0;  // its number at the source
  Time sensed_at{};          // as states tell it: what finds their trace
  Time acquired_at{};        // the slave had it
  Time processed_at{};       // cameras or fingertips had processed it
  Time solved_at{};          // the model was solved, states report it
};

}  // namespace palpate
