// Channels to the slave. What the hand waits for and what may wait never share a connection.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include <grpcpp/channel.h>

namespace palpate {

enum class Traffic : std::uint8_t {
  kTicks,  // small states and commands: a stalled reader shall not find seconds of old states
  kBulk,   // meshes: large messages, a bounded window
};

// The longest round trip that a line is reckoned to have: what answers later is dead.
inline constexpr std::chrono::milliseconds kUsualRoundTrip{1000};

// A connection of its own, reconnecting by itself, never through a proxy. Does not wait. `tls`: the
// folder of who we are and whom to believe; empty: plain text. Throws as ChannelTls does.
std::shared_ptr<grpc::Channel> OpenChannel(
    const std::string& target, Traffic traffic, const std::filesystem::path& tls = {},
    std::chrono::milliseconds longest_round_trip = kUsualRoundTrip);

// `target` as HOST:PORT. Throws std::invalid_argument: not understood, or not loopback without
// leave to go `beyond`.
std::string PermittedTarget(const std::string& target, bool beyond);

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
