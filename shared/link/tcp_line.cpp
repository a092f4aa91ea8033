#include "shared/link/tcp_line.h"

#include <array>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>

namespace palpate {
namespace {

// Converts an IPv4 address that a socket for both families reports as ::ffff:1.2.3.4 to IPv4.
sockaddr_storage Unmapped(const sockaddr_storage& address) {
  const auto& v6 = reinterpret_cast<const sockaddr_in6&>(address);
  if (address.ss_family != AF_INET6 || !IN6_IS_ADDR_V4MAPPED(&v6.sin6_addr)) return address;
  sockaddr_storage unmapped{};
  auto& v4 = reinterpret_cast<sockaddr_in&>(unmapped);
  v4.sin_family = AF_INET;
  v4.sin_port = v6.sin6_port;
  std::memcpy(&v4.sin_addr, &v6.sin6_addr.s6_addr[12], sizeof v4.sin_addr);
  return unmapped;
}

// Returns the address that `ask`, getpeername or getsockname, reports; nullopt without a connection
// over IP.
std::optional<sockaddr_storage> AddressOf(int fd, decltype(getpeername)* ask) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (ask(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0) return std::nullopt;
  if (address.ss_family != AF_INET && address.ss_family != AF_INET6) return std::nullopt;
  return Unmapped(address);
}

// Returns the port, which has the same offset in both address families.
std::uint16_t PortOf(const sockaddr_storage& address) {
  return ntohs(reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

// Returns this process's IP connections to peers that `wanted` accepts.
template <class Wanted>
std::vector<int> LinesThat(const Wanted& wanted) {
  std::vector<int> lines;
  std::error_code none;  // without /proc nothing is found
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", none)) {
    const std::string name = entry.path().filename().string();
    int fd = -1;
    std::from_chars(name.data(), name.data() + name.size(), fd);
    const auto peer = AddressOf(fd, getpeername);
    if (peer && wanted(*peer)) lines.push_back(fd);
  }
  return lines;
}

}  // namespace

void PrepareLine(int fd) noexcept {
  setsockopt(fd, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kMaxUnsent, sizeof kMaxUnsent);
  for (const std::string_view control : {"cubic", "reno"}) {
    const auto size = static_cast<socklen_t>(control.size());
    if (setsockopt(fd, IPPROTO_TCP, TCP_CONGESTION, control.data(), size) == 0) return;
  }
}

std::vector<int> LinesTo(std::uint16_t port) {
  return LinesThat([port](const sockaddr_storage& peer) { return PortOf(peer) == port; });
}

std::string NameOf(const sockaddr_storage& peer) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const auto& v6 = reinterpret_cast<const sockaddr_in6&>(peer);  // the port has one offset in both
  const bool is_v6 = peer.ss_family == AF_INET6;
  const void* const address =
      is_v6 ? static_cast<const void*>(&v6.sin6_addr)
            : static_cast<const void*>(&reinterpret_cast<const sockaddr_in&>(peer).sin_addr);
  inet_ntop(peer.ss_family, address, text.data(), text.size());
  const bool is_of_one_link = is_v6 && v6.sin6_scope_id != 0;
  const std::string link = is_of_one_link ? "%" + std::to_string(v6.sin6_scope_id) : "";
  return std::string(is_v6 ? "ipv6:" : "ipv4:") + text.data() + link + ":" +
         std::to_string(ntohs(v6.sin6_port));
}

std::string WithoutBrackets(std::string peer) {
  for (const std::string_view bracket : {"%5B", "%5D", "[", "]"}) {
    const auto at = peer.find(bracket);
    if (at != std::string::npos) peer.erase(at, bracket.size());
  }
  constexpr std::string_view kPercent = "%25";
  const auto at = peer.find(kPercent);
  if (at != std::string::npos) peer.replace(at, kPercent.size(), "%");
  return peer;
}

std::optional<LineEnds> EndsOf(const std::string& peer) {
  const std::string wanted = WithoutBrackets(peer);
  const auto lines = LinesThat([&](const sockaddr_storage& far) { return NameOf(far) == wanted; });
  if (lines.empty()) return std::nullopt;
  const auto own = AddressOf(lines.front(), getsockname);
  const auto far = AddressOf(lines.front(), getpeername);
  if (!own || !far) return std::nullopt;
  return LineEnds{*own, *far};
}

}  // namespace palpate
