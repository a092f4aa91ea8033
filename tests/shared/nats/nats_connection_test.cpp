// Addresses and subjects, and a connection that cannot be made. tests/e2e/test_observers.py has a
// server.
#include "shared/nats/nats_connection.h"

#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/support/thrown.h"

namespace palpate {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(NatsServerAddress, IsRejectedWithWhatIsAcceptedAndWithoutThePassword) {
  for (const char* url : {"127.0.0.1:4222", "http://a:secret@127.0.0.1:4222", "", "tls://",
                          "nats://a:secret@", "nats://a:secret@host:99999", "nats://host:x"}) {
    EXPECT_THROW(ParseNatsServer(url, true, {}), std::invalid_argument) << url;
    const std::string why = Thrown<std::invalid_argument>([&] { ParseNatsServer(url, true, {}); });
    EXPECT_THAT(why, HasSubstr("expected")) << url;
    EXPECT_THAT(why, Not(HasSubstr("secret"))) << url;
  }
}

TEST(NatsServerAddress, BeyondThisMachineIsPlainTextOnlyIfThatIsAllowed) {
  EXPECT_THROW(ParseNatsServer("nats://10.0.0.5:4222", false, {}), std::invalid_argument);
  EXPECT_NO_THROW(ParseNatsServer("nats://10.0.0.5:4222", true, {}));
  EXPECT_NO_THROW(ParseNatsServer("tls://10.0.0.5:4222", false, {}));
}

TEST(Subjects, ContainNameAndKindOfAnySlave) {
  EXPECT_EQ(SubjectOf("silicone-block", "state"), "palpate.silicone-block.state");
  EXPECT_EQ(SubjectOf("a.b *> c", "mesh"), "palpate.a-b----c.mesh");
  EXPECT_EQ(SubjectOf("", "mesh"), "palpate.slave.mesh");
}

// A local port that is closed, or that accepts connections and sends nothing.
class Port {
 public:
  explicit Port(bool is_open) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof place;
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&place), size), 0);
    EXPECT_EQ(getsockname(socket_, reinterpret_cast<sockaddr*>(&place), &size), 0);
    if (is_open) EXPECT_EQ(listen(socket_, 1), 0);
    url_ = "nats://127.0.0.1:" + std::to_string(ntohs(place.sin_port));
  }
  ~Port() { close(socket_); }
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;
  [[nodiscard]] NatsServer server() const { return ParseNatsServer(url_, false, {}); }
  [[nodiscard]] int socket() const { return socket_; }

 private:
  int socket_;
  std::string url_;
};

TEST(NatsConnection, AMissingServerIsReportedOnceAndMessagesAreDropped) {
  for (const bool is_open : {false, true}) {
    const Port port(is_open);
    std::mutex mutex;
    std::vector<std::string> news;
    {
      NatsConnection connection(port.server(), "test", [&](const std::string& text) {
        const std::scoped_lock lock(mutex);
        news.push_back(text);
      });
      EXPECT_FALSE(connection.Connected());
      EXPECT_FALSE(connection.Publish("palpate.a.state", "bytes"));
      EXPECT_FALSE(connection.Confirm());
    }
    ASSERT_EQ(news.size(), 1U);
    EXPECT_THAT(news[0], HasSubstr("no connection to the NATS server at 127.0.0.1:"));
  }
}

}  // namespace
}  // namespace palpate
