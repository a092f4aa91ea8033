// A terminal that shows the session and reads keys. It uses plain ANSI sequences: three are enough
// to overwrite the screen, and ncurses would take over signals and the state of the terminal.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "master/station/moment_json.h"
#include "master/station/server/page_command.h"

namespace palpate {

// The terminal view as text, for use over ssh. Colours only repeat the words.
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

// Uses the standard input and output. If the output is no terminal, or TERM is `dumb`, it prints
// the text once a second. If the input is no terminal, there are no keys.
class Terminal {
 public:
  // `on_key` is called on a separate thread.
  explicit Terminal(std::function<void(char)> on_key);
  // Restores the terminal.
  ~Terminal();

  struct Size {
    int columns = 80, rows = 40;
  };
  [[nodiscard]] Size size() const;
  // Whether colours are supported and NO_COLOR is not set.
  [[nodiscard]] bool has_colour() const;
  void Show(const std::vector<std::string>& lines);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
