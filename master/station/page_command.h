// What a page asks for: small JSON objects, read with care, since whoever reaches the port may send
// anything.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include <Eigen/Core>

#include "master/haptics/render_mode.h"

namespace palpate {

// The longest message a page may send [bytes].
inline constexpr std::size_t kLongestCommand = 1024;

struct StopCommand {};   // {"do": "stop"}: the emergency stop
struct ResetCommand {};  // {"do": "reset"}: its end
// {"do": "ping", "at": 12.5}: answered with {"kind": "pong", "at": 12.5}.
struct PingCommand {
  double at = 0;  // the page's own clock
};
// {"do": "past"}: answered with {"kind": "past", "samples": [...]}, those of the last 10 s.
struct PastCommand {};
// {"do": "pointer", "at": 12.5, "p_M": [x, y, z], "engaged": true}
struct PointerCommand {
  double at = 0;                 // the page's own clock
  Eigen::Vector3d p_M{0, 0, 0};  // [m], within 10 m
  bool engaged = false;
};
// {"do": "set", "position_scale": 1, "force_scale": 1, "force_limit": 3.3}, each may be absent
struct MappingCommand {
  std::optional<double> position_scale, force_scale, force_limit;  // finite, > 0
};
// {"do": "model", "kind": "fem"}
struct ModelCommand {
  std::string kind;  // 1 to 40 characters of a-z, 0-9, -
};
// {"do": "mark"}: an event worth finding again.
struct MarkCommand {};
// {"do": "tare"}: what is felt now, without contact, is zero.
struct TareCommand {};
// {"do": "find"}: the eyes or fingertips start anew; a stop stays.
struct ReinitializeTrackingCommand {};
// {"do": "examine"}: what the doctor finds, shown to all pages.
struct ExamineCommand {};
// {"do": "clutch", "on": true}: the hand is let go, whatever its device says.
struct ClutchCommand {
  bool on = true;
};
// {"do": "render", "mode": "hold"}
struct RenderCommand {
  RenderMode mode = RenderMode::kLocal;
};
// {"do": "record", "on": true}
struct RecordCommand {
  bool on = true;
};
// {"do": "replay", "playing": true, "speed": 0.5, "to": 12.5}, each may be absent
struct ReplayCommand {
  std::optional<bool> playing;
  std::optional<double> speed;  // times as fast as it was; finite, > 0
  std::optional<double> to;     // [s] since the recording began; finite
};
using PageCommand = std::variant<StopCommand, ResetCommand, PingCommand, PointerCommand,
                                 MappingCommand, ModelCommand, MarkCommand, TareCommand,
                                 ClutchCommand, RenderCommand, RecordCommand, ReplayCommand,
                                 PastCommand, ReinitializeTrackingCommand, ExamineCommand>;

// Throws std::invalid_argument: what is wrong and what is accepted.
PageCommand ReadPageCommand(std::string_view message);

}  // namespace palpate
