// Messages with every field set, for the tests of this folder.
#pragma once

#include "shared/state/slave_state.h"

namespace palpate {

// All fields differ from their defaults and are exact in single precision.
SlaveState FullState();
OperatorCommand FullCommand();

}  // namespace palpate
