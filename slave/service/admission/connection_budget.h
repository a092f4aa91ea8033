// Limit of what one connection may send: bytes per second, and bytes without a solution.
#pragma once

#include <algorithm>
#include <cstdint>

namespace palpate {

class ConnectionBudget {
 public:
  // An operator sends 80 kB/s, five fingertips as much; after a stall of seconds the link delivers
  // all of it at once. For floods of HTTP/2 frames gRPC uses several times their size in memory.
  static constexpr double kRate = 256e3;   // [bytes/s]
  static constexpr double kBurst = 512e3;  // [bytes]
  static constexpr double kStart = 8e3;    // initial allowance of a new connection [bytes]
  static constexpr std::uint64_t kUnanswered = 512 * 1024;  // [bytes]

  // `share`: factor on all limits, more than 1 for scenes that accept images.
  explicit ConnectionBudget(double share = 1) : share_(share) {}

  // Updates with the socket's counters since it was opened, `dt` [s] after the last call. False:
  // beyond the budget. Endless headers get no answer; every stream of our clients does, by states
  // or window updates.
  bool Update(std::uint64_t received, std::uint64_t answered, double dt) {
    const std::uint64_t came = received - received_;
    unanswered_ = answered == answered_ ? unanswered_ + came : 0;
    silent_ = came == 0 && answered == answered_ ? silent_ + dt : 0;
    credit_ = std::min(kBurst, credit_ + kRate * dt) - static_cast<double>(came) / share_;
    received_ = received;
    answered_ = answered;
    return credit_ >= 0 && static_cast<double>(unanswered_) <= share_ * kUnanswered;
  }
  [[nodiscard]] std::uint64_t answered() const { return answered_; }  // [bytes]
  // Since a byte went either way [s].
  [[nodiscard]] double silent() const { return silent_; }

 private:
  std::uint64_t received_ = 0, answered_ = 0, unanswered_ = 0;
  double share_, credit_ = kStart, silent_ = 0;
};

}  // namespace palpate
