// A state of the slave as it arrived: the record that recording and page use.
#pragma once

#include <memory>

#include "shared/state/clock.h"

namespace palpate {

namespace v1 {
class SlaveState;
}

struct StateRecord {
  // Its numbers are accepted (FromProto). Null: none yet. The events of states that datagrams
  // overtook are added.
  std::shared_ptr<const v1::SlaveState> message;
  Time received_at{};  // master's clock
};

}  // namespace palpate
