// How long to wait before the next attempt: twice as long each time, up to a limit.
#pragma once

#include <algorithm>
#include <chrono>

namespace palpate {

class Backoff {
 public:
  // 0 < first <= longest.
  Backoff(std::chrono::milliseconds first, std::chrono::milliseconds longest)
      : first_(first), longest_(longest), next_(first) {}

  // The wait before the next attempt.
  std::chrono::milliseconds Next() {
    const auto wait = next_;
    next_ = std::min(2 * next_, longest_);
    return wait;
  }
  // An attempt succeeded: start anew.
  void Reset() { next_ = first_; }

 private:
  std::chrono::milliseconds first_, longest_, next_;
};

}  // namespace palpate
