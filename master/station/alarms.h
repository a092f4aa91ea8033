// What is wrong at a moment, in words, each with the next step: for page and terminal alike.
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
  std::string text, next;  // what is wrong; what to do about it, may be empty
};
std::string_view ToString(Alarm::Level level);  // `warn`, `bad`

// How the line to the slave is, and whom the slave takes this station for.
struct LineState {
  std::string_view word;  // `lost`; `connected`: the slave answers, no states; `degraded`; `good`
  std::string why;        // it is degraded
  std::string_view role;  // `operator`; `observer`: the slave does not serve it; empty: not known
};
LineState LineOf(const StationMoment& moment);

// The worst need not come first: in the order of a force's way. Empty: nothing is wrong.
std::vector<Alarm> AlarmsOf(const StationMoment& moment);

}  // namespace palpate
