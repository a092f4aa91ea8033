// Tests Operate with states and commands that are also sent by datagram.
#include <atomic>
#include <cmath>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include <gtest/gtest.h>
#include <netinet/in.h>

#include "shared/link/datagram_line.h"
#include "shared/link/tcp_line.h"
#include "tests/slave/service/service_fixture.h"

namespace palpate {
namespace {

v1::OperatorCommand DatagramRequest() {
  v1::OperatorCommand command;
  command.set_sequence(1);
  command.set_datagrams(true);
  return command;
}

v1::OperatorCommand Engaged(std::uint64_t sequence, double y) {
  v1::OperatorCommand command;
  command.set_sequence(sequence);
  command.set_epoch(1);
  command.set_engaged(true);
  command.mutable_p_m()->set_y(y);
  return command;
}

// The operator's end of the datagrams that `offer` describes.
class Far {
 public:
  Far(const v1::DatagramOffer& offer, const std::string& address)
      : line_(DatagramLine::Role::kCalls, At(offer, address),
              {*DatagramKeyFrom(offer.command_key()), *DatagramKeyFrom(offer.state_key())},
              [this](std::string_view plain) {
                Take(plain);
                return DatagramLine::LinkFeedback{};
              }) {}

  void Send(const v1::OperatorCommand& command) { line_.Send(command.SerializeAsString()); }
  // Sends `command` again and again, as none need arrive.
  bool SendUntil(const v1::OperatorCommand& command, const std::function<bool()>& condition) {
    return Eventually([&] {
      Send(command);
      return condition();
    });
  }
  [[nodiscard]] int states() const { return states_; }
  [[nodiscard]] v1::SlaveState newest() const {
    const std::scoped_lock lock(mutex_);
    return newest_;
  }

 private:
  static sockaddr_storage At(const v1::DatagramOffer& offer, const std::string& address) {
    sockaddr_storage at = EndsOf("ipv4:" + address)->far;
    reinterpret_cast<sockaddr_in&>(at).sin_port = htons(static_cast<in_port_t>(offer.port()));
    return at;
  }
  void Take(std::string_view plain) {
    const std::scoped_lock lock(mutex_);
    EXPECT_TRUE(newest_.ParseFromArray(plain.data(), static_cast<int>(plain.size())));
    EXPECT_EQ(newest_.events_size(), 0) << "a datagram that is lost would lose them";
    ++states_;
  }

  mutable std::mutex mutex_;  // guards the next one
  v1::SlaveState newest_;
  std::atomic<int> states_{0};
  DatagramLine line_;  // last: its thread uses all of the above
};

class OperateDatagramsTest : public ServiceTest {
 protected:
  static std::optional<v1::DatagramOffer> OfferTo(Operator* who) {
    who->Send(DatagramRequest());
    const auto offer = who->ReadUntil([](const auto& state) { return state.has_datagrams(); });
    return offer ? std::optional(offer->datagrams()) : std::nullopt;
  }
  Operator ada{Connect()};
};

// An old command that arrives late must not move the tool back, whether by stream or datagram.
TEST_F(OperateDatagramsTest, DatagramsOlderThanTheStreamAreDropped) {
  const auto offer = OfferTo(&ada);
  ASSERT_TRUE(offer.has_value());
  Far far(*offer, server_->address());
  ada.Send(Engaged(10, 0));
  ASSERT_TRUE(ada.ReadUntil([](const auto& s) { return s.command_sequence() == 10; }));
  ASSERT_TRUE(far.SendUntil(Engaged(5, -9e-3), [&] { return far.states() > 5; }));
  EXPECT_EQ(far.newest().command_sequence(), 10U);
  EXPECT_EQ(far.newest().p_s_tip().y(), FakeSlave::kHome);
}

TEST_F(OperateDatagramsTest, DatagramsAreOfferedOnceAndOnlyOnRequest) {
  ada.Hold(0);
  const auto followed = ada.ReadUntil([](const auto& state) {
    EXPECT_FALSE(state.has_datagrams());
    return state.command_sequence() == 1;
  });
  ASSERT_TRUE(followed.has_value());
  ASSERT_TRUE(OfferTo(&ada).has_value());
  ada.Send(DatagramRequest());
  v1::OperatorCommand last = DatagramRequest();
  last.set_sequence(9);
  ada.Send(last);
  EXPECT_TRUE(ada.ReadUntil([](const auto& state) {
    EXPECT_FALSE(state.has_datagrams());
    return state.command_sequence() == 9;
  }));
}

TEST_F(OperateDatagramsTest, ObserversNeverSeeTheKeys) {
  const auto stub = Connect();
  CallContext context;
  const auto watched = stub->WatchState(&context, {});
  ASSERT_TRUE(OfferTo(&ada).has_value());
  v1::SlaveState state;
  do {
    ASSERT_TRUE(watched->Read(&state));
    EXPECT_FALSE(state.has_datagrams());
  } while (state.command_sequence() == 0);
  context.TryCancel();
}

// A datagram sealed for one stream is refused in the next one, at the same port or another.
TEST_F(OperateDatagramsTest, TheKeysEndWithTheirStream) {
  const auto old = OfferTo(&ada);
  ASSERT_TRUE(old.has_value());
  Far left(*old, server_->address());
  ASSERT_TRUE(left.SendUntil(Engaged(2, 0), [&] { return left.states() > 0; }));
  EXPECT_TRUE(ada.Leave().ok());
  Operator bob(Connect());
  const auto offer = OfferTo(&bob);
  ASSERT_TRUE(offer.has_value());
  EXPECT_EQ(offer->port(), old->port());
  EXPECT_NE(offer->command_key(), old->command_key());
  const int heard = left.states();
  Far far(*offer, server_->address());
  ASSERT_TRUE(far.SendUntil(DatagramRequest(), [&] {
    left.Send(Engaged(99, -9e-3));
    return far.states() > 20;
  }));
  EXPECT_EQ(left.states(), heard);
  EXPECT_EQ(far.newest().command_sequence(), 1U);
  EXPECT_NE(far.newest().phase(), v1::PHASE_FOLLOWING);
}

TEST_F(OperateDatagramsTest, UnreadableCommandsAreCountedReportedAndNotFollowed) {
  const auto offer = OfferTo(&ada);
  ASSERT_TRUE(offer.has_value());
  Far far(*offer, server_->address());
  ASSERT_TRUE(far.SendUntil(Engaged(2, NAN), [&] { return far.states() > 0; }));
  EXPECT_TRUE(ada.ReadUntil([](const auto& s) { return HasEvent(s, v1::EVENT_COMMAND_REFUSED); }));
  EXPECT_GT(GetStatus().commands_refused(), 0U);
  EXPECT_EQ(far.newest().p_s_tip().y(), FakeSlave::kHome);
}

TEST_F(OperateDatagramsTest, AStoppingServerLetsThePortGo) {
  const auto offer = OfferTo(&ada);
  ASSERT_TRUE(offer.has_value());
  Far far(*offer, server_->address());
  ASSERT_TRUE(far.SendUntil(Engaged(2, 0), [&] { return far.states() > 0; }));
  server_->Stop();
  const int heard = far.states();
  far.Send(Engaged(3, -9e-3));
  EXPECT_EQ(slave_.ends(), 1);
  EXPECT_EQ(far.states(), heard);
  sockaddr_storage own{};
  own.ss_family = AF_INET;
  reinterpret_cast<sockaddr_in&>(own).sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  reinterpret_cast<sockaddr_in&>(own).sin_port = htons(static_cast<in_port_t>(offer->port()));
  const DatagramLine next(DatagramLine::Role::kAnswers, own, {},
                          [](std::string_view) { return DatagramLine::LinkFeedback{}; });
  EXPECT_EQ(next.port(), offer->port());
}

}  // namespace
}  // namespace palpate
