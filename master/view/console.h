// Where the operator's lines go: one live line on a terminal, plain lines in a pipe.
#pragma once

#include <cstdio>
#include <optional>
#include <string>

#include "master/haptics/session.h"

namespace palpate {

class Console {
 public:
  // `out` stays open while the console lives; `live`: it is a terminal.
  Console(std::FILE* out, bool live) : out_(out), live_(live) {}
  // On the standard output, live if that is a terminal.
  static Console Standard();
  ~Console() { EndLine(); }
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  // A line of its own.
  void Say(const std::string& line);
  // Live: replaces the status line. In a pipe: a line each second and at each change of state.
  void Show(const Status& status);

 private:
  void EndLine();

  std::FILE* out_;
  bool live_;
  bool open_ = false;  // a live line stands without its end
  std::optional<OperatorState> state_;
  double said_ = 0;  // when the last plain line was printed [s]
};

}  // namespace palpate
