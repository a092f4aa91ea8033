// A terminal that shows the station and listens to keys. Plain ANSI: a screen that is written over
// needs three sequences, its text is a function that tests call, and ncurses would want signals and
// the terminal's whole state for itself.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace palpate {

// Of the standard input and output. Where the output is no terminal, or TERM is `dumb`, the text is
// written once a second, one below the other; where the input is none, there are no keys.
class Terminal {
 public:
  // `on_key` is called from a thread of its own.
  explicit Terminal(std::function<void(char)> on_key);
  // As the terminal was before.
  ~Terminal();

  struct Size {
    int columns = 80, rows = 40;
  };
  [[nodiscard]] Size size() const;
  // It takes colours, and nobody set NO_COLOR.
  [[nodiscard]] bool has_colour() const;
  void Show(const std::vector<std::string>& lines);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
