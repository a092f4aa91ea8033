// The station in a terminal, as text: what a person over ssh needs at a glance. Every mark is a
// word as well, so that colour may be left out.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "master/station/moment_json.h"
#include "master/station/page_command.h"

namespace palpate {

struct TerminalLook {
  int columns = 80, rows = 40;  // lines are cut to the one, their number to the other
  bool colour = false;          // ANSI colours
};

// Its lines, from state and force down to the keys; a pure function. What is not known is `-`.
std::vector<std::string> TerminalText(const StationHello& hello, const StationMoment& moment,
                                      const std::vector<LogEntry>& said, const TerminalLook& look);

// What a key asks for; nothing: it is none of a terminal's own. As in a plain session, a hand that
// strikes the keyboard means to stop: whatever key is not known does.
std::optional<PageCommand> CommandOfKey(char key, const StationMoment& moment);
inline constexpr char kQuitKey = 'q';

}  // namespace palpate
