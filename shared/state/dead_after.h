// How long a link may be silent before both ends take it for dead (contracts, wire). A scene may
// say more where the network jitters, within bounds that neither end lets the other exceed: the
// hand's force outlives the line by this.
#pragma once

namespace palpate {

inline constexpr double kUsualDeadAfter = 0.030;                          // [s]
inline constexpr double kLeastDeadAfter = 0.010, kMostDeadAfter = 0.500;  // [s]

}  // namespace palpate
