// Two random alterations at the same time.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/campaigns/robustness/case.h"

namespace palpate::robustness {

// `first`, then `second`. They must not both choose which sample is shown.
Alteration Both(const Alteration& first, const Alteration& second);

// `count` pairs of `cases`, all different; none may have an undetected error, each may be flagged.
std::vector<Case> Mixed(const std::vector<Case>& cases, std::size_t count, std::uint64_t seed);

}  // namespace palpate::robustness
