// Datagrams on a link where an attacker damages, repeats, reorders and forges them.
#pragma once

#include "tests/support/choices.h"

namespace palpate {

// Throws std::logic_error if a datagram is accepted that was not sealed, or is not newer than the
// last one.
void RunDatagrams(Choices choices);

}  // namespace palpate
