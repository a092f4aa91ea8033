// Where the operator's lines go: live lines on a terminal, plain lines in a pipe.
#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "master/haptics/session.h"
#include "master/link/remote_mesh.h"

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
  // Live: replaces the status line and the table of fingertips below it. In a pipe: a line each
  // second and at each change of state. `mesh`: the object's shape, null: not watched.
  void Show(const Status& status, const RemoteMesh* mesh = nullptr);
  [[nodiscard]] bool live() const { return live_; }

 private:
  void ShowLive(const std::vector<std::string>& lines);
  void EndLine();

  std::FILE* out_;
  bool live_;
  std::size_t open_ = 0;  // live lines that stand there, the last without its end
  std::optional<OperatorState> state_;
  double said_ = 0;  // when the last plain line was printed [s]
};

}  // namespace palpate
