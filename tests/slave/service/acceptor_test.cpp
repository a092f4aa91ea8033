// Tests admission control: which connections are passed to gRPC, which are closed, and that it
// keeps running.
#include "slave/service/admission/acceptor.h"

#include <atomic>
#include <cerrno>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include "shared/link/tcp_line.h"
#include "tests/slave/service/service_fixture.h"

namespace palpate {
namespace {

// A client with its own socket.
class Client {
 public:
  explicit Client(const Endpoint& endpoint) : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(endpoint.port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) ADD_FAILURE();
  }
  ~Client() { close(fd_); }
  void Send(std::size_t bytes) const {
    const std::string words(bytes, 'x');
    static_cast<void>(send(fd_, words.data(), words.size(), MSG_NOSIGNAL | MSG_DONTWAIT));
  }
  // Returns whether the connection has ended.
  [[nodiscard]] bool IsClosed() const {
    char byte = 0;
    const ssize_t count = recv(fd_, &byte, 1, MSG_DONTWAIT);
    return count == 0 || (count < 0 && errno != EAGAIN);
  }

 private:
  int fd_;
};

class AcceptorTest : public testing::Test {
 protected:
  ~AcceptorTest() override {
    acceptor_.reset();
    for (const int fd : handed_on_) close(fd);
  }
  void Make(const Acceptor::Limits& limits) {
    acceptor_ = std::make_unique<Acceptor>(
        Endpoint{"127.0.0.1", 0},
        [this](int fd) {
          const std::scoped_lock lock(mutex_);
          handed_on_.push_back(fd);
        },
        limits);
  }
  void Open(const Acceptor::Limits& limits) {
    Make(limits);
    acceptor_->Start();
  }
  std::unique_ptr<Client> Connect(std::size_t bytes = 24) {
    auto client = std::make_unique<Client>(acceptor_->endpoint());
    client->Send(bytes);
    return client;
  }
  [[nodiscard]] std::uint64_t Closed(TurnedAway why) const {
    return acceptor_->counts().turned_away[static_cast<std::size_t>(why)];
  }
  [[nodiscard]] bool HandsOn(std::uint64_t count) const {
    return Eventually([&] { return acceptor_->counts().accepted == count; });
  }
  // Returns gRPC's name of the connection that was passed on as number `i`, from 0.
  std::string PeerOf(std::size_t i) {
    const std::scoped_lock lock(mutex_);
    sockaddr_in address{};
    socklen_t size = sizeof address;
    getpeername(handed_on_[i], reinterpret_cast<sockaddr*>(&address), &size);
    return "ipv4:127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  }
  // Describes the first connection and waits until that is applied.
  void DescribeFirst() {
    const auto is_applied = std::make_shared<std::atomic<bool>>(false);
    acceptor_->Describe(PeerOf(0), {.trusted = [is_applied] { return *is_applied = true; }});
    ASSERT_TRUE(Eventually([&] { return is_applied->load(); }));
  }
  // Reads all data, as gRPC would.
  void ReadAll() {
    const std::scoped_lock lock(mutex_);
    std::vector<char> bytes(1 << 20);
    for (const int fd : handed_on_) {
      while (recv(fd, bytes.data(), bytes.size(), MSG_DONTWAIT) > 0) {
      }
    }
  }

  std::unique_ptr<Acceptor> acceptor_;
  std::mutex mutex_;
  std::vector<int> handed_on_;
};

TEST_F(AcceptorTest, AConnectionIsPassedOnWithAllItsData) {
  Open({});
  const auto client = Connect();
  ASSERT_TRUE(HandsOn(1));
  const std::scoped_lock lock(mutex_);
  std::string bytes(64, ' ');
  EXPECT_EQ(recv(handed_on_[0], bytes.data(), bytes.size(), 0), 24);
  int max_unsent = 0;
  socklen_t size = sizeof max_unsent;
  getsockopt(handed_on_[0], IPPROTO_TCP, TCP_NOTSENT_LOWAT, &max_unsent, &size);
  EXPECT_EQ(max_unsent, kMaxUnsent);
}

TEST_F(AcceptorTest, AConnectionWithoutAStreamIsClosedIfAllPlacesAreTaken) {
  Open({.connections = 1});
  const auto idle = Connect();
  ASSERT_TRUE(HandsOn(1));
  const auto next = Connect();
  EXPECT_TRUE(HandsOn(2));
  EXPECT_TRUE(Eventually([&] { return idle->IsClosed(); }));
  EXPECT_FALSE(next->IsClosed());
}

TEST_F(AcceptorTest, BeyondTheLimitConnectionsAreClosedUntilAPlaceIsFree) {
  Open({.connections = 1});
  auto one = Connect();
  ASSERT_TRUE(HandsOn(1));
  DescribeFirst();
  const auto other = Connect();
  EXPECT_TRUE(Eventually([&] { return other->IsClosed(); }));
  EXPECT_EQ(Closed(TurnedAway::kFull), 1U);
  EXPECT_FALSE(one->IsClosed());
  one.reset();
  ASSERT_TRUE(Eventually([&] { return acceptor_->counts().open == 0; }));
  const auto next = Connect();
  EXPECT_TRUE(HandsOn(2));
}

TEST_F(AcceptorTest, AConnectionThatIsNotTrustedIsClosed) {
  Open({});
  const auto one = Connect(), other = Connect();
  ASSERT_TRUE(HandsOn(2));
  const std::string peer = PeerOf(0);
  std::atomic<bool> trusted{true};
  acceptor_->Describe("ipv4:127.0.0.1:1", {.trusted = [] { return false; }});  // is not here
  acceptor_->Describe(peer, {.trusted = [&] { return trusted.load(); }});
  trusted = false;
  EXPECT_TRUE(Eventually([&] { return Closed(TurnedAway::kUntrusted) == 1; }));
  EXPECT_NE(one->IsClosed(), other->IsClosed());
}

// Reference: HTTP/2 lets a client send 64 kB before it has the server's settings.
TEST_F(AcceptorTest, AClientThatSendsTooMuchTooEarlyIsClosed) {
  Make({});
  const auto client = Connect(60'000), flood = Connect(1'000'000);
  acceptor_->Start();
  EXPECT_TRUE(HandsOn(1));
  EXPECT_TRUE(Eventually([&] { return flood->IsClosed(); }));
  EXPECT_TRUE(Eventually([&] { return Closed(TurnedAway::kTooMuch) == 1; }));
  EXPECT_FALSE(client->IsClosed());
}

TEST_F(AcceptorTest, OfAllConnectionsTheOneThatSendsMostIsClosed) {
  Open({.rate = 10e3, .burst = 50e3});
  const auto little = Connect(), much = Connect();
  ASSERT_TRUE(HandsOn(2));
  EXPECT_TRUE(Eventually([&] {
    little->Send(10);
    much->Send(5000);
    ReadAll();
    return Closed(TurnedAway::kTooMuch) == 1;
  }));
  EXPECT_TRUE(Eventually([&] { return much->IsClosed(); }));
  EXPECT_FALSE(little->IsClosed());
  const auto next = Connect();
  EXPECT_TRUE(HandsOn(3)) << "after a pause";
}

TEST_F(AcceptorTest, AConnectionWithARateOfItsOwnMaySendThat) {
  Open({.rate = 1e3, .burst = 10e3});
  const auto operating = Connect();
  ASSERT_TRUE(HandsOn(1));
  acceptor_->Describe(PeerOf(0), {.rate = 1e6});
  acceptor_->Describe(PeerOf(0), {.rate = 1e3});  // a second stream that may send less
  DescribeFirst();                                // another stream of the connection
  for (int i = 0; i < 10; ++i) {                  // 100 kB, a tenth of the credit
    operating->Send(10'000);
    ReadAll();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_FALSE(operating->IsClosed());
  EXPECT_TRUE(Eventually([&] {
    operating->Send(100'000);
    ReadAll();
    return Closed(TurnedAway::kTooMuch) == 1;
  })) << "but no more";
}

}  // namespace
}  // namespace palpate
