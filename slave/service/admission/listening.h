// The slave's listening sockets.
#pragma once

#include <string>
#include <vector>

#include "shared/link/loopback.h"

namespace palpate {

// Open until destruction.
class ListeningSocket {
 public:
  explicit ListeningSocket(int fd) : fd_(fd) {}
  ListeningSocket(ListeningSocket&& other) noexcept : fd_(other.fd_) { other.fd_ = -1; }
  ListeningSocket& operator=(ListeningSocket&&) = delete;
  ListeningSocket(const ListeningSocket&) = delete;
  ListeningSocket& operator=(const ListeningSocket&) = delete;
  ~ListeningSocket();
  [[nodiscard]] int fd() const { return fd_; }

 private:
  int fd_;
};

// One for each address that `endpoint->host` has on this machine, all at one port, which is filled
// in where it was 0. Throws std::runtime_error: host unknown, port in use (no silent sharing), not
// an address of this machine, not permitted.
std::vector<ListeningSocket> ListenAt(Endpoint* endpoint);

}  // namespace palpate
