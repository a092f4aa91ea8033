// Channels to the slave. Haptic traffic and bulk traffic never share a connection.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include <grpcpp/channel.h>
#include <grpcpp/support/status.h>

namespace palpate {

enum class Traffic : std::uint8_t {
  kTicks,  // small states and commands, with small buffers, so that old states do not accumulate
  kBulk,   // large messages, such as meshes, with a bounded window
};

// Default of the max accepted round trip: a later answer counts as a dead link.
inline constexpr std::chrono::milliseconds kUsualRoundTrip{1000};

// Opens a separate connection that reconnects by itself and never uses a proxy. Does not wait.
// `tls`: folder with the certificates; empty: plain text. Throws the exceptions of ChannelTls.
std::shared_ptr<grpc::Channel> OpenChannel(
    const std::string& target, Traffic traffic, const std::filesystem::path& tls = {},
    std::chrono::milliseconds max_round_trip = kUsualRoundTrip);

// Returns `target` as HOST:PORT. Throws std::invalid_argument if it is invalid, or beyond loopback
// without `beyond`.
std::string PermittedTarget(const std::string& target, bool beyond);

// All calls of this process belong to the operator `name` from now on, for slaves in plain text.
// Called once, before the first call.
void NameCalls(const std::string& name);

// Wait before the next attempt: doubles each time, up to a limit.
class Backoff {
 public:
  // 0 < first <= max.
  Backoff(std::chrono::milliseconds first, std::chrono::milliseconds max)
      : first_(first), max_(max), next_(first) {}

  // The wait before the next attempt.
  std::chrono::milliseconds Next() {
    const auto wait = next_;
    next_ = std::min(2 * next_, max_);
    return wait;
  }
  // Records that an attempt succeeded: the next pause is `first` again.
  void Reset() { next_ = first_; }

 private:
  std::chrono::milliseconds first_, max_, next_;
};

// The reason of `status`: at most 300 printable characters, because the peer may be malicious. A
// message of the slave itself is kept; empty without one.
std::string WordsOf(const grpc::Status& status);

}  // namespace palpate
