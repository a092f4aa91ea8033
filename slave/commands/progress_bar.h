// Progress of long work on a terminal: expected cost, progress and stop.
#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <string_view>

#include "slave/program/progress.h"

namespace palpate {

// On a terminal one line, redrawn at most ten times per second:
//
//   solve: Green's functions [###########.............]  46 %, 12 s left
//
// elsewhere plain lines: at every stage that takes time, and every 10 % of it. Work that ends
// within half a second prints nothing. Called by one thread.
class ProgressBar final : public Progress {
 public:
  // Destination of the text; tests use their own.
  struct Output {
    bool is_terminal = false;
    int columns = 80;                             // of the terminal
    std::function<void(std::string_view)> write;  // bytes as they are
    std::function<double()> now;                  // [s], from any zero
  };

  // Draws on standard error. `name` begins every line.
  explicit ProgressBar(std::string name, std::stop_token stop = {});
  ProgressBar(std::string name, std::stop_token stop, Output output);
  // Removes the bar.
  ~ProgressBar() override;

  // Prints the expected cost, unless it is too small to matter.
  void Expect(const PrecomputeCost& cost) override;
  // Returns false after a stop was requested.
  bool Report(std::string_view stage, double done) override;
  // Removes the bar, so that other text can be printed; the next report draws it again.
  void Clear();

 private:
  void Draw(double now, double done);
  void WriteLine(double now, double done);

  std::string name_;
  std::stop_token stop_;
  Output output_;
  double started_ = 0;  // [s]
  bool long_ = false;   // whether the work takes long or is expected to
  std::string stage_;
  double stage_started_ = 0;  // [s]
  double drawn_at_ = 0;       // [s]
  int tenths_printed_ = -1;   // of this stage, plain lines
  bool on_screen_ = false;
};

}  // namespace palpate
