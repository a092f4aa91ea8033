#include "shared/link/loopback.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <stdexcept>

#include <arpa/inet.h>
#include <netinet/in.h>

namespace palpate {
namespace {

[[noreturn]] void Refuse(const std::string& address) {
  throw std::invalid_argument(address +
                              ": expected HOST:PORT or [IPV6]:PORT with a port from 0 to 65535");
}

// Accepts addresses with and without the name of a link: fe80::1%eth0.
bool IsV6(const std::string& host) {
  const auto percent = host.find('%');
  in6_addr v6{};
  return inet_pton(AF_INET6, host.substr(0, percent).c_str(), &v6) == 1 &&
         percent != host.size() - 1 &&
         host.find_first_of("[]/: \t\n", percent) == std::string::npos;
}

}  // namespace

Endpoint ParseEndpoint(const std::string& address) {
  const auto colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0) Refuse(address);
  Endpoint endpoint;
  endpoint.host = address.substr(0, colon);
  const bool bracketed = endpoint.host.front() == '[' && endpoint.host.back() == ']';
  if (bracketed) endpoint.host = endpoint.host.substr(1, endpoint.host.size() - 2);
  const bool is_v6 = IsV6(endpoint.host);
  const bool plain = endpoint.host.find_first_of("[]/: \t\n") == std::string::npos;
  if (endpoint.host.empty() || bracketed != is_v6 || (!is_v6 && !plain)) Refuse(address);

  const char* const end = address.data() + address.size();
  const auto [stop, error] = std::from_chars(address.data() + colon + 1, end, endpoint.port);
  if (error != std::errc{} || stop != end) Refuse(address);
  return endpoint;
}

std::string ToString(const Endpoint& endpoint) {
  const bool is_v6 = endpoint.host.find(':') != std::string::npos;
  return (is_v6 ? "[" + endpoint.host + "]" : endpoint.host) + ":" + std::to_string(endpoint.port);
}

bool IsLoopback(const std::string& host) {
  in_addr v4{};
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return (ntohl(v4.s_addr) >> 24U) == 127;
  in6_addr v6{};
  if (inet_pton(AF_INET6, host.c_str(), &v6) == 1) {
    return IN6_IS_ADDR_LOOPBACK(&v6) || (IN6_IS_ADDR_V4MAPPED(&v6) && v6.s6_addr[12] == 127);
  }
  std::string name = host;
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name == "localhost";
}

void RequireLoopbackUnless(bool insecure, const Endpoint& endpoint) {
  if (insecure || IsLoopback(endpoint.host)) return;
  throw std::invalid_argument(
      ToString(endpoint) +
      ": without --insecure, expected a loopback address (127.0.0.1, "
      "[::1] or localhost), because plain text is sent; --tls DIR encrypts it");
}

}  // namespace palpate
