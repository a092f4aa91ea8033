// Settings of TCP connections between master and slave, which gRPC does not offer.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <sys/socket.h>

namespace palpate {

// Largest amount of unsent data [bytes], about 40 states. The next state is written when there is
// room, and is then the newest one.
inline constexpr int kMaxUnsent = 8 * 1024;

// Bounds the unsent data. Also replaces the congestion control BBR, which sends only four packets
// in a round trip every ten seconds, a gap of seconds on a slow link. Settings that the system
// rejects stay unchanged.
void PrepareLine(int fd) noexcept;
// Connections of this process to the peer's `port`, because gRPC does not provide them.
std::vector<int> LinesTo(std::uint16_t port);

// The name of a peer as in gRPC, without IPv6 brackets and escapes, which gRPC writes
// inconsistently. A link-local address has the number of its link (fe80::1%2).
std::string NameOf(const sockaddr_storage& peer);
std::string WithoutBrackets(std::string peer);

struct LineEnds {
  sockaddr_storage own, far;
};
// Ends of this process's connection with the gRPC peer `peer`; nullopt: none is open.
std::optional<LineEnds> EndsOf(const std::string& peer);

}  // namespace palpate
