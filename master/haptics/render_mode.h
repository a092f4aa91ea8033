// How forces are made between two states.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace palpate {

enum class RenderMode : std::uint8_t {
  kLocal,        // the local model at the newest hand position: the best of its steps
  kInterpolate,  // the last forces, a period late (DelayedLinear)
  kHold,         // the newest force until the next
};
inline constexpr int kRenderModes = 3;
std::string_view ToString(RenderMode mode);  // `local`, `interpolate`, `hold`
std::optional<RenderMode> ParseRenderMode(std::string_view text);

}  // namespace palpate
