#include "shared/link/tcp_line.h"

#include <array>
#include <string>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

namespace palpate {
namespace {

// A TCP connection over loopback and the socket options of its near end.
class Connection {
 public:
  Connection() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    auto* any = reinterpret_cast<sockaddr*>(&address);
    socklen_t size = sizeof address;
    if (bind(listener_, any, size) != 0 || listen(listener_, 1) != 0 ||
        getsockname(listener_, any, &size) != 0 || connect(near_, any, size) != 0) {
      ADD_FAILURE() << "no connection";
    }
    port = ntohs(address.sin_port);
  }
  ~Connection() {
    close(near_);
    close(listener_);
  }

  // Selects the congestion control. Returns false if this system does not have it.
  [[nodiscard]] bool Choose(const std::string& control) const {
    return setsockopt(near_, IPPROTO_TCP, TCP_CONGESTION, control.data(),
                      static_cast<socklen_t>(control.size())) == 0;
  }
  [[nodiscard]] std::string control() const {
    std::array<char, 16> name{};
    socklen_t size = name.size();
    getsockopt(near_, IPPROTO_TCP, TCP_CONGESTION, name.data(), &size);
    return name.data();
  }
  [[nodiscard]] int max_unsent() const {
    int bytes = 0;
    socklen_t size = sizeof bytes;
    getsockopt(near_, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &bytes, &size);
    return bytes;
  }

  std::uint16_t port = 0;

 private:
  int listener_ = socket(AF_INET, SOCK_STREAM, 0), near_ = socket(AF_INET, SOCK_STREAM, 0);
};

TEST(TcpLineTest, OnlyConnectionsToThePortAreFound) {
  const Connection meant, other;
  EXPECT_EQ(LinesTo(meant.port).size(), 1U);
  for (const int line : LinesTo(meant.port)) PrepareLine(line);
  EXPECT_EQ(meant.max_unsent(), kMaxUnsent);
  EXPECT_NE(other.max_unsent(), kMaxUnsent);
  EXPECT_TRUE(LinesTo(1).empty());
  PrepareLine(-1);  // nothing happens
}

}  // namespace
}  // namespace palpate
