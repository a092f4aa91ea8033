#include "shared/metrics/metrics_page.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace palpate {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

Metrics OneNumber() {
  return {Gauge("palpate_answer", "An answer.", 42)};
}

class MetricsPageTest : public testing::Test {
 protected:
  // Returns a connection whose reads wait 20 s at most.
  [[nodiscard]] int Connect() const {
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(page_.endpoint().port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    const timeval timeout{20, 0};
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
    return fd;
  }
  static bool Send(int fd, std::string_view words) {
    return send(fd, words.data(), words.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(words.size());
  }
  // Reads until the server closes the connection.
  static std::string Hear(int fd) {
    std::string heard;
    std::array<char, 4096> bytes{};
    ssize_t got = 0;
    while ((got = recv(fd, bytes.data(), bytes.size(), 0)) > 0) {
      heard.append(bytes.data(), static_cast<std::size_t>(got));
    }
    return got == 0 ? heard : heard + " and no end";
  }
  [[nodiscard]] std::string Query(const std::string& what) const {
    const int fd = Connect();
    EXPECT_TRUE(Send(fd, what + " HTTP/1.1\r\nHost: here\r\n\r\n"));
    const std::string answer = Hear(fd);
    close(fd);
    return answer;
  }
  MetricsPage page_{"127.0.0.1:0", false, OneNumber};
};

// Clients that send nothing or single bytes do not keep others from the page; they are disconnected
// after a while.
TEST_F(MetricsPageTest, SlowClientsAreDisconnected) {
  constexpr int kMore = 24;  // more than the maximum number of clients
  std::vector<int> lingering;
  for (int i = 0; i < kMore; ++i) lingering.push_back(Connect());
  std::jthread dripping([lingering](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      for (const int fd : lingering) Send(fd, "G");
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  });
  EXPECT_THAT(Query("GET /metrics"), HasSubstr("palpate_answer 42\n"));
  std::array<char, 1> byte{};
  for (const int fd : lingering) {
    const bool cut = recv(fd, byte.data(), 1, 0) == 0 || errno == ECONNRESET;
    EXPECT_TRUE(cut) << "still there";
  }
  dripping = {};
  for (const int fd : lingering) close(fd);
}

TEST(MetricsPageAddressTest, BeyondThisMachineOnlyIfAsked) {
  EXPECT_THAT([] { MetricsPage("0.0.0.0:0", false, OneNumber); },
              ThrowsMessage<std::runtime_error>(HasSubstr("--metrics: ")));
  EXPECT_NO_THROW(MetricsPage("0.0.0.0:0", true, OneNumber));
}

}  // namespace
}  // namespace palpate
