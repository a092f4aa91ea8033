// Datagrams on a link where an attacker damages, repeats, reorders and forges them.
#pragma once

#include "tests/support/choices.h"

namespace palpate {

// Throws std::logic_error where something opens that was not sealed, or not later than the last.
void RunDatagrams(Choices choices);

}  // namespace palpate
