// Commands of a page: small JSON objects. They are checked, because any program may send them.
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
inline constexpr std::size_t kMaxCommandBytes = 1024;

struct StopCommand {};   // {"do": "stop"}: the emergency stop
struct ResetCommand {};  // {"do": "reset"}: resets it
// {"do": "ping", "at": 12.5}: answered with {"kind": "pong", "at": 12.5}.
struct PingCommand {
  double at = 0;  // clock of the page
};
// {"do": "past"}: answered with {"kind": "past", "samples": [...]}, those of the last 10 s.
struct PastCommand {};
// {"do": "pointer", "at": 12.5, "p_M": [x, y, z], "engaged": true, "gap": 0.02}
struct PointerCommand {
  double at = 0;                 // clock of the page
  Eigen::Vector3d p_M{0, 0, 0};  // [m], within 10 m
  bool engaged = false;
  double gap = 0;  // see Pointer::MaxSilence [s], >= 0; may be absent
};
// {"do": "set", "position_scale": 1, "force_scale": 1, "force_limit": 3.3}, each may be absent
struct MappingCommand {
  std::optional<double> position_scale, force_scale, force_limit;  // finite, > 0
};
// {"do": "model", "kind": "fem"}
struct ModelCommand {
  std::string kind;  // 1 to 40 characters of a-z, 0-9, -
};
// {"do": "mark"}: marks an event.
struct MarkCommand {};
// {"do": "tare"}: takes the present force without contact as zero.
struct TareCommand {};
// {"do": "find"}: reinitializes tracking; an emergency stop stays active.
struct ReinitializeTrackingCommand {};
// {"do": "clutch", "on": true}: opens the clutch, regardless of the device.
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
  std::optional<double> speed;  // relative to real time; finite, > 0
  std::optional<double> to;     // time in the recording [s]; finite
};
// {"do": "field", "on": true}: this page shows the displacement field. It ends with the page.
struct FieldCommand {
  bool on = true;
};
using PageCommand = std::variant<StopCommand, ResetCommand, PingCommand, PointerCommand,
                                 MappingCommand, ModelCommand, MarkCommand, TareCommand,
                                 ClutchCommand, RenderCommand, RecordCommand, ReplayCommand,
                                 PastCommand, ReinitializeTrackingCommand, FieldCommand>;

// Throws std::invalid_argument with the problem and what is accepted.
PageCommand ReadPageCommand(std::string_view message);

}  // namespace palpate
