// Channels to the slave. What the hand waits for and what may wait never share a connection.
#pragma once

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

}  // namespace palpate
