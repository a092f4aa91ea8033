// Addresses as people write them, and whether they stay on this machine: plain text is served and
// spoken over loopback only, unless the user says otherwise.
#pragma once

#include <cstdint>
#include <string>

namespace palpate {

struct Endpoint {
  std::string host;  // without brackets
  std::uint16_t port = 0;
};

// `HOST:PORT` or `[V6]:PORT`, port 0 to 65535; V6 of one link with its name, fe80::1%eth0. Throws
// std::invalid_argument: what was given, what is accepted.
Endpoint ParseEndpoint(const std::string& address);
// `HOST:PORT`, an IPv6 address in brackets.
std::string ToString(const Endpoint& endpoint);
// 127.0.0.0/8, ::1, the same written as ::ffff:127.0.0.1, or `localhost`. Other names are not
// looked up: where they lead may change.
bool IsLoopback(const std::string& host);
// Throws std::invalid_argument unless `endpoint` is loopback or `insecure`.
void RequireLoopbackUnless(bool insecure, const Endpoint& endpoint);

}  // namespace palpate
