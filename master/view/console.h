// What the operator reads, and where the lines go: live lines on a terminal, plain lines in a pipe.
#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "master/haptics/session.h"
#include "master/link/remote_mesh.h"
#include "master/link/remote_scene.h"

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
  void Print(const std::string& line);
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

// One line that says how it goes: state, rate, round trip, age, force. For example
//   `  12.3 s  FOLLOWING     1000 Hz  RTT 0.21 ms  age   3 ms   1.23 N [#######.............]
//   clamped`
// The bar is full at the force limit; what changed the force comes last, then what troubles the
// link. Unknown numbers are shown as `-`.
std::string FormatStatus(const Status& status);

// What the fingertips feel and how far the object gives way: one line per fingertip and one for the
// object, for example
//   `  ff       touches    0.412 N  (-0.410 +0.030 +0.020) N`
//   `  th       free`
//   `  object   moved by up to 4.20 mm`
// The vector is the force of the object on the fingertip, frame S. A lone tool, which the status
// line already tells of, has no line of its own. `mesh`: null, nobody watches it or none came.
std::vector<std::string> FingerTable(const std::vector<NamedFinger>& fingers,
                                     const RemoteMesh* mesh);

// The same in one line: `  ff 0.41 N  th free  moved 4.2 mm`.
std::string FingerBrief(const std::vector<NamedFinger>& fingers, const RemoteMesh* mesh);

// Who they are: `fingertips ff (rnn_21; polarity-free), th (no network: its force stays unknown)`.
std::string FingertipsInWords(const std::vector<RemoteFingertip>& fingertips);

// The run as a person reads it: two columns, a line per figure, ends with a newline.
std::string FormatSummary(const Report& report);

}  // namespace palpate
