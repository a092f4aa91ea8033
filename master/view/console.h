// Text output for the operator: live lines on a terminal, plain lines in a pipe.
#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "master/link/remote_mesh.h"
#include "master/link/remote_scene.h"
#include "master/session/session.h"

namespace palpate {

class Console {
 public:
  // `out` must stay open while this object exists. `live`: it is a terminal.
  Console(std::FILE* out, bool live) : out_(out), live_(live) {}
  // Writes to the standard output, live if that is a terminal.
  static Console Standard();
  ~Console() { EndLine(); }
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  // Prints a separate line.
  void Print(const std::string& line);
  // Live: replaces the status line and the table of fingertips below it. In a pipe: prints a line
  // each second and at each change of state. `mesh`: the object's shape; null: unknown.
  void Show(const SessionStatus& status, const RemoteMesh* mesh = nullptr);
  [[nodiscard]] bool live() const { return live_; }

 private:
  void ShowLive(const std::vector<std::string>& lines);
  void EndLine();

  std::FILE* out_;
  bool live_;
  std::size_t open_ = 0;  // number of live lines, the last without a line end
  std::optional<OperatorState> state_;
  double printed_at_ = 0;  // when the last plain line was printed [s]
};

// `force` as a share of `limit`, a bar of `width` characters in brackets.
std::string ForceBar(double force, double limit, int width);
// The status line: state, rate, round trip, age, force. For example
//   `  12.3 s  FOLLOWING     1000 Hz  RTT 0.21 ms  age   3 ms   1.23 N [#######.............]
//   clamped`
// The bar is full at the force limit. The reasons of changes come last, then problems of the link.
// Unknown numbers are shown as `-`.
std::string FormatStatus(const SessionStatus& status);

// Forces of the fingertips and deflection of the object: one line per fingertip and one for the
// object, for example
//   `  ff       contact    0.412 N  (-0.410 +0.030 +0.020) N`
//   `  th       free`
//   `  object   moved by up to 4.20 mm`
// The vector is the force of the object on the fingertip, frame S. A single tool has no line,
// because the status line contains it. `mesh`: null if unknown.
std::vector<std::string> FingerTable(const std::vector<NamedFinger>& fingers,
                                     const RemoteMesh* mesh);

// Returns all fingertips in one line: `  ff 0.41 N  th free  moved 4.2 mm`.
std::string FingerBrief(const std::vector<NamedFinger>& fingers, const RemoteMesh* mesh);

// Names and networks, for example `fingertips ff (rnn_21; polarity-free), th (no neural network:
// its force is unknown)`.
std::string FingertipsInWords(const std::vector<RemoteFingertip>& fingertips);

// The summary of a run: two columns, one line per value. Ends with a newline.
std::string FormatSummary(const Report& report);

}  // namespace palpate
