// Channels to the slave. What the hand waits for and what may wait never share a connection.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include <grpcpp/channel.h>

namespace palpate {

enum class Traffic : std::uint8_t {
  kTicks,  // small states and commands: a stalled reader shall not find seconds of old states
  kBulk,   // meshes: large messages, a bounded window
};

// A connection of its own, reconnecting by itself, never through a proxy. Does not wait.
std::shared_ptr<grpc::Channel> OpenChannel(const std::string& target, Traffic traffic);

// `target` as HOST:PORT. Throws std::invalid_argument: not understood, or not loopback without
// `insecure`.
std::string PermittedTarget(const std::string& target, bool insecure);

// How long to wait before the next attempt: twice as long each time, up to a limit.
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
