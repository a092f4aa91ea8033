#include "slave/service/admission/listening.h"

#include <cerrno>
#include <cstring>
#include <memory>
#include <stdexcept>

#include <linux/tcp.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace palpate {
namespace {

constexpr int kBacklog = 128;
// [bytes] of a segment, as on Ethernet: one of loopback's, 32 kB, would not fit into the little
// room that the door leaves to who is new, and the line would stall.
constexpr int kLargestSegment = 1440;

[[noreturn]] void Refuse(const Endpoint& endpoint, const std::string& why) {
  throw std::runtime_error("cannot listen on " + ToString(endpoint) + ": " + why);
}

void Switch(int fd, int level, int option, int value) {
  setsockopt(fd, level, option, &value, sizeof value);
}

// -1: errno says why.
int Listen(const addrinfo& address) {
  const int fd = socket(address.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return fd;
  Switch(fd, SOL_SOCKET, SO_REUSEADDR, 1);  // of what just ended, not of what listens
  Switch(fd, IPPROTO_TCP, TCP_MAXSEG, kLargestSegment);
  if (address.ai_family == AF_INET6) Switch(fd, IPPROTO_IPV6, IPV6_V6ONLY, 1);
  if (bind(fd, address.ai_addr, address.ai_addrlen) == 0 && listen(fd, kBacklog) == 0) return fd;
  const int error = errno;
  close(fd);
  errno = error;
  return -1;
}

std::uint16_t PortOf(int fd) {
  sockaddr_in6 address{};  // the port stands at the same place as in sockaddr_in
  socklen_t size = sizeof address;
  getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin6_port);
}

void SetPort(addrinfo* address, std::uint16_t port) {
  reinterpret_cast<sockaddr_in6*>(address->ai_addr)->sin6_port = htons(port);
}

}  // namespace

ListeningSocket::~ListeningSocket() {
  if (fd_ >= 0) close(fd_);
}

std::vector<ListeningSocket> ListenAt(Endpoint* endpoint) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  const int unknown = getaddrinfo(endpoint->host.c_str(), nullptr, &hints, &found);
  if (unknown != 0) Refuse(*endpoint, gai_strerror(unknown));
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, freeaddrinfo);
  std::vector<ListeningSocket> sockets;
  int last = 0;
  for (addrinfo* address = found; address != nullptr; address = address->ai_next) {
    SetPort(address, endpoint->port);
    const int fd = Listen(*address);
    if (fd < 0) last = errno;
    if (fd < 0 && last == EADDRINUSE) Refuse(*endpoint, std::strerror(last));  // in one family
    if (fd < 0) continue;
    sockets.emplace_back(fd);
    endpoint->port = PortOf(fd);
  }
  if (sockets.empty()) Refuse(*endpoint, std::strerror(last));
  return sockets;
}

}  // namespace palpate
