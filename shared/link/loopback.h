// Parses addresses and checks for loopback. Plain text is used over loopback only, unless the user
// permits more.
#pragma once

#include <cstdint>
#include <string>

namespace palpate {

struct Endpoint {
  std::string host;  // without brackets
  std::uint16_t port = 0;
};

// Parses `HOST:PORT` or `[V6]:PORT`, port 0 to 65535. A link-local V6 address has a zone, as in
// fe80::1%eth0. Throws std::invalid_argument with what is accepted.
Endpoint ParseEndpoint(const std::string& address);
// `HOST:PORT`, an IPv6 address in brackets.
std::string ToString(const Endpoint& endpoint);
// Returns whether `host` is in 127.0.0.0/8, ::1, an IPv4-mapped form of these, or `localhost`.
// Other names are not resolved, because their address may change.
bool IsLoopback(const std::string& host);
// Throws std::invalid_argument unless `endpoint` is loopback or `insecure`.
void RequireLoopbackUnless(bool insecure, const Endpoint& endpoint);

}  // namespace palpate
