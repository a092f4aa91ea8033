// The door before gRPC: who is let in, who is turned away, and that it goes on doing so.
#include "slave/service/admission/acceptor.h"

#include <algorithm>
#include <array>
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
#include "slave/service/admission/connection_budget.h"
#include "tests/slave/service/service_fixture.h"

namespace palpate {
namespace {

using namespace std::string_literals;

const std::string kPreface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";

// A stranger with a socket of its own.
class Stranger {
 public:
  explicit Stranger(const Endpoint& endpoint) : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(endpoint.port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) ADD_FAILURE();
  }
  ~Stranger() { close(fd_); }
  void Send(const std::string& words) const {
    static_cast<void>(send(fd_, words.data(), words.size(), MSG_NOSIGNAL));
  }
  // Its end came, by whatever is read of it.
  [[nodiscard]] bool IsOut() const {
    char byte = 0;
    const ssize_t came = recv(fd_, &byte, 1, MSG_DONTWAIT);
    return came == 0 || (came < 0 && errno != EAGAIN);
  }

 private:
  int fd_;
};

class AcceptorTest : public testing::Test {
 protected:
  ~AcceptorTest() override {
    door_.reset();
    for (const int fd : handed_on_) close(fd);
  }
  void Open(const Acceptor::Limits& limits, Greeting greeting = Greeting::kHttp2) {
    door_ = std::make_unique<Acceptor>(
        Endpoint{"127.0.0.1", 0}, greeting,
        [this](int fd) {
          const std::scoped_lock lock(mutex_);
          handed_on_.push_back(fd);
        },
        limits);
    door_->Start();
  }
  std::unique_ptr<Stranger> Come(const std::string& words = kPreface) {
    auto stranger = std::make_unique<Stranger>(door_->endpoint());
    stranger->Send(words);
    return stranger;
  }
  [[nodiscard]] std::uint64_t Turned(TurnedAway why) const {
    return door_->counts().turned_away[static_cast<std::size_t>(why)];
  }
  [[nodiscard]] bool LetsIn(std::uint64_t count) const {
    return Eventually([&] { return door_->counts().accepted == count; });
  }
  // As gRPC names the one that came in as number `i`, from 0.
  std::string PeerOf(std::size_t i) {
    const std::scoped_lock lock(mutex_);
    sockaddr_in address{};
    socklen_t size = sizeof address;
    getpeername(handed_on_[i], reinterpret_cast<sockaddr*>(&address), &size);
    return "ipv4:127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  }

  std::unique_ptr<Acceptor> door_;
  std::mutex mutex_;
  std::vector<int> handed_on_;
};

TEST(JudgeTest, AGreetingIsKnownByItsFirstBytesAndNothingElseIsOne) {
  for (std::size_t n = 0; n < kPreface.size(); ++n) {
    EXPECT_EQ(CheckGreeting(Greeting::kHttp2, kPreface.substr(0, n)), Greets::kNotYet) << n;
  }
  EXPECT_EQ(CheckGreeting(Greeting::kHttp2, kPreface), Greets::kYes);
  EXPECT_EQ(CheckGreeting(Greeting::kHttp2, kPreface + "more"), Greets::kYes);
  for (const auto& other : {"GET / HTTP/1.1\r\n"s, "\x16\x03\x01"s, "\0"s, "PRI * HTTP/1"s}) {
    EXPECT_EQ(CheckGreeting(Greeting::kHttp2, other), Greets::kNo) << other;
  }
  const std::string hello = "\x16\x03\x01\x02\x00\x01"s;
  for (std::size_t n = 0; n < hello.size(); ++n) {
    EXPECT_EQ(CheckGreeting(Greeting::kTls, hello.substr(0, n)), Greets::kNotYet) << n;
  }
  EXPECT_EQ(CheckGreeting(Greeting::kTls, hello), Greets::kYes);
  for (const auto& other : {kPreface, "\x16\x02"s, "\x15\x03\x01"s, "\x16\x03\x01\x02\x00\x02"s}) {
    EXPECT_EQ(CheckGreeting(Greeting::kTls, other), Greets::kNo) << other;
  }
}

TEST_F(AcceptorTest, WhoeverGreetsComesInWholeAndWhoeverSaysOtherThingsDoesNot) {
  Open({});
  const auto client = Come(kPreface + "and more");
  ASSERT_TRUE(LetsIn(1));
  {
    const std::scoped_lock lock(mutex_);
    std::array<char, 64> seen{};
    const ssize_t came = recv(handed_on_[0], seen.data(), seen.size(), 0);
    EXPECT_EQ(std::string(seen.data(), static_cast<std::size_t>(came)), kPreface + "and more");
    int most_unsent = 0;
    socklen_t size = sizeof most_unsent;
    getsockopt(handed_on_[0], IPPROTO_TCP, TCP_NOTSENT_LOWAT, &most_unsent, &size);
    EXPECT_EQ(most_unsent, kMostUnsent);
  }
  const auto browser = Come("GET / HTTP/1.1\r\n\r\n");
  EXPECT_TRUE(Eventually([&] { return browser->IsOut(); }));
  EXPECT_EQ(Turned(TurnedAway::kSaidOther), 1U);
  EXPECT_FALSE(client->IsOut());
}

TEST_F(AcceptorTest, AGreetingThatDoesNotEndIsNotWaitedForForEver) {
  Open({.greeting = std::chrono::milliseconds(30)});
  const auto silent = Come(""), half = Come(kPreface.substr(0, 10));
  EXPECT_TRUE(Eventually([&] { return silent->IsOut() && half->IsOut(); }));
  EXPECT_EQ(Turned(TurnedAway::kSaidNothing), 2U);
  EXPECT_EQ(door_->counts().accepted, 0U);
}

// Reference: issue 12; 1100 connections that said nothing made a listener of gRPC deaf for good.
TEST_F(AcceptorTest, AThousandThatSayNothingKeepNobodyOut) {
  Open({.waiting = 16, .greeting = kLiveness});
  std::vector<std::unique_ptr<Stranger>> crowd;
  for (int i = 0; i < 400; ++i) crowd.push_back(Come(""));
  const auto client = Come();
  EXPECT_TRUE(LetsIn(1));
  EXPECT_GE(Turned(TurnedAway::kSaidNothing), 380U);
}

// gRPC's threads, which read the operator's commands too, greet one in less than a millisecond.
TEST_F(AcceptorTest, ACrowdComesInOneByOne) {
  Open({});
  const Time begin = Clock::now();
  std::vector<std::unique_ptr<Stranger>> crowd;
  for (int i = 0; i < 32; ++i) crowd.push_back(Come());
  EXPECT_TRUE(LetsIn(32));
  EXPECT_GE(SecondsBetween(begin, Clock::now()), 31 * 4e-3);
}

TEST_F(AcceptorTest, NoAddressTakesAllPlacesUnlessItUsesThem) {
  Open({.per_address = 2, .greeting = std::chrono::milliseconds(50), .idle = 1e9});
  const auto one = Come(), two = Come();
  ASSERT_TRUE(LetsIn(2));
  const auto third = Come();
  EXPECT_TRUE(Eventually([&] { return third->IsOut(); }));
  EXPECT_EQ(Turned(TurnedAway::kTooMany), 1U);
  EXPECT_FALSE(one->IsOut());
}

TEST_F(AcceptorTest, TheIdlestGivesWayWhereNoPlaceIsLeft) {
  Open({.per_address = 2, .idle = 0.05});
  const auto idle = Come(), busy = Come();
  ASSERT_TRUE(LetsIn(2));
  std::jthread talking([&](const std::stop_token& stop) {
    for (; !stop.stop_requested(); std::this_thread::sleep_for(std::chrono::milliseconds(5))) {
      busy->Send("x");
    }
  });
  std::vector<std::unique_ptr<Stranger>> others;
  EXPECT_TRUE(Eventually([&] {
    others.push_back(Come());
    return door_->counts().accepted >= 3;
  }));
  EXPECT_TRUE(idle->IsOut());
  EXPECT_FALSE(busy->IsOut());
}

TEST_F(AcceptorTest, APlaceIsFreeAgainWhenItsGuestLeaves) {
  Open({.per_address = 1, .idle = 1e9});
  auto one = Come();
  ASSERT_TRUE(LetsIn(1));
  one.reset();
  const auto next = Come();
  EXPECT_TRUE(LetsIn(2));
}

// Reference: issue 12; of 1100 that greeted, those that waited and had left were let in first, 50 a
// second, and a new client had its answer after two seconds.
TEST_F(AcceptorTest, WhoGreetedAndLeftTakesNobodysTurn) {
  Open({.closed = 0, .rate = 2, .burst = 1});
  const auto first = Come();
  ASSERT_TRUE(LetsIn(1));
  for (int i = 0; i < 50; ++i) Come();
  ASSERT_TRUE(Eventually([&] { return Turned(TurnedAway::kSaidNothing) >= 49; }));
  const auto client = Come();
  EXPECT_TRUE(Eventually([&] { return door_->counts().accepted >= 2 && !client->IsOut(); }));
  EXPECT_LE(door_->counts().accepted, 3U);
}

TEST_F(AcceptorTest, WhoeverIsTrustedNoMoreIsCut) {
  Open({});
  const auto one = Come(), other = Come();
  ASSERT_TRUE(LetsIn(2));
  const std::string peer = PeerOf(0);
  std::atomic<bool> trusted{true};
  door_->KeepWhile("ipv4:127.0.0.1:1", [] { return false; });  // is not here
  door_->KeepWhile(peer, [&] { return trusted.load(); });
  trusted = false;
  EXPECT_TRUE(Eventually([&] { return one->IsOut(); }));
  EXPECT_TRUE(Eventually([&] { return Turned(TurnedAway::kUntrusted) == 1; }));
  EXPECT_FALSE(other->IsOut());
}

TEST_F(AcceptorTest, WhoWatchesIsPacedWhileSomebodyOperatesFromElsewhere) {
  Open({});
  const auto watcher = Come(), operating = Come();
  ASSERT_TRUE(LetsIn(2));
  const auto most_of = [this](std::size_t i) {
    const std::scoped_lock lock(mutex_);
    unsigned most = 0;
    socklen_t size = sizeof most;
    getsockopt(handed_on_[i], SOL_SOCKET, SO_MAX_PACING_RATE, &most, &size);
    return most;
  };
  door_->Pace(PeerOf(0));
  door_->Pace(PeerOf(1));  // watches, too
  EXPECT_TRUE(Eventually([&] {
    door_->HearRoundTrip(PeerOf(1), 1e-3);
    return most_of(0) == static_cast<unsigned>(BulkPace::kLeast);
  }));
  EXPECT_EQ(most_of(1), ~0U);
}

TEST_F(AcceptorTest, WhoFloodsAtOnceNeverComesIn) {
  Open({});
  const auto flood = Come(kPreface + std::string(60'000, 'x'));
  EXPECT_TRUE(Eventually([&] { return Turned(TurnedAway::kTooMuch) == 1; }));
  EXPECT_EQ(door_->counts().accepted, 0U);
}

// Reference: a client that waited for its turn was turned away after 3 s: each new flood closed the
// door anew.
TEST_F(AcceptorTest, FloodsOfAnAddressDoNotKeepItsClientsOut) {
  Open({.closed = 0.1});
  std::jthread flooding([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      const auto flood = Come(kPreface + std::string(60'000, 'x'));
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  ASSERT_TRUE(Eventually([&] { return Turned(TurnedAway::kTooMuch) > 3; }));
  const auto client = Come();
  EXPECT_TRUE(LetsIn(1));
  EXPECT_FALSE(client->IsOut());
}

TEST_F(AcceptorTest, WhoeverFloodsIsCut) {
  Open({});
  const auto flood = Come(), other = Come();
  ASSERT_TRUE(LetsIn(2));
  EXPECT_TRUE(Eventually([&] {
    flood->Send(std::string(100'000, 'x'));
    const std::scoped_lock lock(mutex_);  // who listens reads it all
    std::vector<char> read(1 << 20);
    for (const int fd : handed_on_) recv(fd, read.data(), read.size(), MSG_DONTWAIT);
    return Turned(TurnedAway::kTooMuch) == 1;
  }));
  EXPECT_FALSE(other->IsOut());
}

TEST(ConnectionBudgetTest, AnOperatorAtHalfAMegabitStays) {
  ConnectionBudget budget;
  for (std::uint64_t i = 1; i < 100'000; ++i) ASSERT_TRUE(budget.Update(1600 * i, 2000 * i, 0.02));
}

TEST(ConnectionBudgetTest, WhatAStallHeldBackMayComeAtOnce) {
  ConnectionBudget budget;
  for (std::uint64_t i = 1; i <= 500; ++i) ASSERT_TRUE(budget.Update(800 * i, i, 0.01));
  EXPECT_TRUE(budget.Update(400'000 + 80'000 * 5, 501, 0.02));
}

TEST(ConnectionBudgetTest, BytesBeyondTheRateOrThatNothingAnswersAreTooMuch) {
  ConnectionBudget fast, unanswered;
  EXPECT_FALSE(fast.Update(2'000'000, 1, 0.02));
  bool bears = true;
  std::uint64_t sent = 0;
  for (; bears && sent < 10'000'000; sent += 4000) bears = unanswered.Update(sent, 7, 0.02);
  EXPECT_FALSE(bears) << "200 kB/s, never answered";
  EXPECT_LT(sent, 600'000U);
}

}  // namespace
}  // namespace palpate
