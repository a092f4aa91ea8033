// The page of `verify --forces`: verdicts, estimated over measured force, and the error over time.
#pragma once

#include <string>
#include <vector>

#include "slave/commands/verify/force_card.h"

namespace palpate {

// An SVG document. `pairs`: in order; the axes of `card` are drawn.
std::string DrawForces(const std::string& title, const ForceCard& card,
                       const std::vector<MatchedState>& pairs);

}  // namespace palpate
