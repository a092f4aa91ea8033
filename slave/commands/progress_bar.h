// Long work on a terminal: what it will cost, how far it is, and how it is told to stop.
#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <string_view>

#include "shared/text/progress.h"

namespace palpate {

// On a terminal one line that is drawn over, ten times a second at most:
//
//   solve: Green's functions [###########.............]  46 %, 12 s left
//
// elsewhere plain lines: at every stage that takes time, and every 10 % of it. Work that is over
// within half a second says nothing. Called by one thread.
class ProgressBar final : public Progress {
 public:
  // Where the words go; the tests put their own here.
  struct Output {
    bool is_terminal = false;
    int columns = 80;                             // of the terminal
    std::function<void(std::string_view)> write;  // bytes as they are
    std::function<double()> now;                  // [s], from any zero
  };

  // Draws on standard error. `name` stands before every line.
  explicit ProgressBar(std::string name, std::stop_token stop = {});
  ProgressBar(std::string name, std::stop_token stop, Output output);
  // Takes the bar away.
  ~ProgressBar() override;

  // Says what is expected, unless that is over before anyone has read it.
  void Expect(const PrecomputeCost& cost) override;
  // False once the stop was requested.
  bool Report(std::string_view stage, double done) override;
  // Takes the bar away, so that something else can be printed; the next report brings it back.
  void Clear();

 private:
  void Draw(double now, double done);
  void WriteLine(double now, double done);

  std::string name_;
  std::stop_token stop_;
  Output output_;
  double started_ = 0;  // [s]
  bool long_ = false;   // long work is expected, or has turned out to be
  std::string stage_;
  double stage_started_ = 0;  // [s]
  double drawn_at_ = 0;       // [s]
  int tenths_said_ = -1;      // of this stage, plain lines
  bool on_screen_ = false;
};

}  // namespace palpate
