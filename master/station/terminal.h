// A terminal that shows the session and reads keys. It uses plain ANSI sequences: three are enough
// to overwrite the screen, and ncurses would take over signals and the state of the terminal.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace palpate {

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
