#include "shared/link/tcp_line.h"

#include <charconv>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

namespace palpate {
namespace {

// -1: no connection over IP.
int PeersPort(int fd) {
  sockaddr_storage peer{};
  socklen_t size = sizeof peer;
  if (getpeername(fd, reinterpret_cast<sockaddr*>(&peer), &size) != 0) return -1;
  if (peer.ss_family != AF_INET && peer.ss_family != AF_INET6) return -1;
  return ntohs(reinterpret_cast<const sockaddr_in&>(peer).sin_port);  // at one place in both
}

}  // namespace

void PrepareLine(int fd) noexcept {
  setsockopt(fd, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kMostUnsent, sizeof kMostUnsent);
  for (const std::string_view control : {"cubic", "reno"}) {
    const auto size = static_cast<socklen_t>(control.size());
    if (setsockopt(fd, IPPROTO_TCP, TCP_CONGESTION, control.data(), size) == 0) return;
  }
}

std::vector<int> LinesTo(std::uint16_t port) {
  std::vector<int> lines;
  std::error_code none;  // without /proc nothing is found
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", none)) {
    const std::string name = entry.path().filename().string();
    int fd = -1;
    std::from_chars(name.data(), name.data() + name.size(), fd);
    if (PeersPort(fd) == port) lines.push_back(fd);
  }
  return lines;
}

}  // namespace palpate
