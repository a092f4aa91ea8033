// Link timeout: both ends regard a silent link as dead after this time. A scene
// may set a longer one for networks with jitter, within bounds that each end enforces, because the
// force on the device continues for this time.
#pragma once

namespace palpate {

inline constexpr double kUsualDeadAfter = 0.030;                       // [s]
inline constexpr double kMinDeadAfter = 0.010, kMaxDeadAfter = 0.500;  // [s]

}  // namespace palpate
