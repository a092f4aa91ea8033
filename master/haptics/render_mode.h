// RenderMode selects how the force between two states is computed.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace palpate {

enum class RenderMode : std::uint8_t {
  kLocal,        // the local model at the present device position, in its best level
  kInterpolate,  // received forces, interpolated with a delay (DelayedLinear)
  kHold,         // the newest received force
};
std::string_view ToString(RenderMode mode);  // `local`, `interpolate`, `hold`
std::optional<RenderMode> ParseRenderMode(std::string_view text);

}  // namespace palpate
