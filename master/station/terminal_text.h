// The terminal view as text, for use over ssh. Colours only repeat the words.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "master/station/moment_json.h"
#include "master/station/server/page_command.h"

namespace palpate {

struct TerminalLook {
  int columns = 80, rows = 40;  // lines are cut to `columns`, their number to `rows`
  bool colour = false;          // ANSI colours
};

// The lines of the view, from state and force down to the keys. Unknown values are `-`.
std::vector<std::string> TerminalText(const StationHello& hello, const StationMoment& moment,
                                      const std::vector<LogEntry>& said, const TerminalLook& look);

// The command of a key; empty: quit. Any unknown key is the emergency stop, as without --tui.
std::optional<PageCommand> CommandOfKey(char key, const StationMoment& moment);
inline constexpr char kQuitKey = 'q';

}  // namespace palpate
