#include "shared/metrics/metrics_page.h"

#include <chrono>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>
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
  httplib::Result Get(const char* path) {
    httplib::Client client("127.0.0.1", page_.endpoint().port);
    client.set_read_timeout(std::chrono::seconds(20));
    return client.Get(path);
  }
  MetricsPage page_{"127.0.0.1:0", false, OneNumber};
};

TEST_F(MetricsPageTest, TellsItsNumbersToWhoeverAsks) {
  for (int again = 0; again < 3; ++again) {
    const auto answer = Get("/metrics");
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->status, 200);
    EXPECT_THAT(answer->body, HasSubstr("palpate_answer 42\n"));
  }
}

TEST_F(MetricsPageTest, HasNothingElse) {
  for (const char* path : {"/", "/metrics/../etc/passwd", "/other"}) {
    const auto answer = Get(path);
    ASSERT_TRUE(answer) << path;
    EXPECT_EQ(answer->status, 404) << path;
  }
}

// Connections that say nothing cost the next who asks a while, and the program nothing.
TEST_F(MetricsPageTest, WhoSaysNothingIsLeftBehind) {
  std::vector<int> silent;
  for (int i = 0; i < 2; ++i) {
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(page_.endpoint().port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ASSERT_EQ(connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    silent.push_back(fd);
  }
  const auto answer = Get("/metrics");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 200);
  for (const int fd : silent) close(fd);
}

TEST_F(MetricsPageTest, APortInUseIsNotShared) {
  const std::string taken = ToString(page_.endpoint());
  EXPECT_THAT([&] { MetricsPage(taken, false, OneNumber); },
              ThrowsMessage<std::runtime_error>(HasSubstr("cannot listen on " + taken)));
}

TEST(MetricsPageAddressTest, BeyondThisMachineOnlyIfToldSo) {
  EXPECT_THAT([] { MetricsPage("0.0.0.0:0", false, OneNumber); },
              ThrowsMessage<std::runtime_error>(HasSubstr("--metrics: ")));
  EXPECT_NO_THROW(MetricsPage("0.0.0.0:0", true, OneNumber));
}

}  // namespace
}  // namespace palpate
