// When a sample came through the slave, stage by stage. Slave's clock.
#pragma once

#include <cstdint>

#include "shared/state/clock.h"

namespace palpate {

struct SampleTrace {
  std::uint64_t sample = 0;  // its number at the source
  Time sensed_at{};          // as states tell it: what finds their trace
  Time acquired_at{};        // the slave had it
  Time seen_at{};            // eyes or fingertips had done with it
  Time felt_at{};            // the model had, and states told of it
};

}  // namespace palpate
