// Alarms with the next step, for the page.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

struct StationMoment;

struct Alarm {
  enum class Level : std::uint8_t { kNote, kStop };
  Level level = Level::kNote;
  std::string text, next;  // the problem; what to do, may be empty
};
std::string_view ToString(Alarm::Level level);  // `warn`, `bad`

// State of the link, and the role of this station.
struct LineState {
  std::string_view
      word;         // `lost`, `connected` (the slave answers without states), `degraded` or `good`
  std::string why;  // why it is degraded
  std::string_view role;  // `operator`; `observer` without the lease; empty: unknown
};
LineState LineOf(const StationMoment& moment);

// Present alarms in the order of the processing of a force, not of severity.
std::vector<Alarm> AlarmsOf(const StationMoment& moment);

}  // namespace palpate
