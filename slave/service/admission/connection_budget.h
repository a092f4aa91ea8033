// What one connection may send before it is cut: bytes a second, and bytes that nothing answers.
#pragma once

#include <algorithm>
#include <cstdint>

namespace palpate {

class ConnectionBudget {
 public:
  // An operator sends 80 kB/s, five fingertips as much; a line that stalled for seconds delivers
  // that at once. Floods of HTTP/2 frames make gRPC keep several times what they send.
  static constexpr double kRate = 256e3;                    // [bytes/s]
  static constexpr double kBurst = 512e3;                   // [bytes]
  static constexpr double kStart = 8e3;                     // of that, for who just came [bytes]
  static constexpr std::uint64_t kUnanswered = 512 * 1024;  // [bytes]

  // `share`: of all of these, more than 1 where scenes take more.
  explicit ConnectionBudget(double share = 1) : share_(share) {}

  // What the socket counted since it was opened, `dt` [s] after the last time. False: beyond the
  // budget. Headers without end are answered by nothing; every stream of ours is, by states or by
  // room for more.
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
