// The verdicts of `verify` on positions: where the tip is, and how far it travels.
#pragma once

#include <vector>

#include "slave/commands/verify/force_card.h"

namespace palpate {

// Adds "Tip position", where the object's size and positions are known, and "Position scale", from
// positions or else from depths.
void AddPosition(const std::vector<MatchedState>& matched, const SetUp& set_up, ForceCard* card);

}  // namespace palpate
