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

// The worst need not come first: in the order of a force's way. Empty: nothing is wrong.
std::vector<Alarm> AlarmsOf(const StationMoment& moment);

}  // namespace palpate
