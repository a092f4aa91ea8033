// Measures the stages of a pipeline.
#pragma once

#include <chrono>

namespace palpate {

class Stopwatch {
 public:
  // Time since the last lap [us].
  double Lap() {
    const auto now = std::chrono::steady_clock::now();
    const double us = std::chrono::duration<double, std::micro>(now - last_).count();
    last_ = now;
    return us;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace palpate
