// What the system does with a TCP connection between hand and tool. gRPC does not say.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <sys/socket.h>

namespace palpate {

// So much of what was written may wait for the line [bytes], some 40 states: the next state is
// written when there is room for it, and is the newest one then.
inline constexpr int kMostUnsent = 8 * 1024;

// Bounds what waits unsent, and leaves BBR, if that is the system's choice: once in ten seconds it
// sends four packets in a round trip to measure the line, which is a silence of seconds on a long
// one. What the system refuses stays as it is.
void PrepareLine(int fd) noexcept;
// This process's connections to a peer's `port`, since gRPC hands out none.
std::vector<int> LinesTo(std::uint16_t port);

// A peer of a connection over IP as gRPC names it, an address of one link with the link's number
// (fe80::1%2), but without the brackets of IPv6 and the escapes, which it does not always write
// alike.
std::string NameOf(const sockaddr_storage& peer);
std::string WithoutBrackets(std::string peer);

struct LineEnds {
  sockaddr_storage own, far;
};
// Of this process's connection with `peer`, as gRPC names it; nullopt: none is open.
std::optional<LineEnds> EndsOf(const std::string& peer);

}  // namespace palpate
