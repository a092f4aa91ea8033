// Tests haptic loop, link and slave with their real threads over a real connection.
#include <atomic>
#include <cmath>
#include <numbers>
#include <optional>
#include <stop_token>
#include <thread>

#include <gtest/gtest.h>

#include "master/haptics/haptic_loop.h"
#include "master/haptics/stop_path.h"
#include "master/link/operator_calls.h"
#include "master/link/slave_link.h"
#include "slave/service/server.h"
#include "tests/joined/joined_slave.h"
#include "tests/master/haptics/test_device.h"
#include "tests/support/dice.h"
#include "tests/support/eventually.h"

namespace palpate {
namespace {

// A device that presses 3 mm deep and retreats once per second.
class Hand final : public TestDevice {
 public:
  std::atomic<bool> is_engaged{false}, is_faulty{false};

  DeviceReading Read(Time now) noexcept override {
    DeviceReading reading;
    const double phase = 2 * std::numbers::pi * SecondsBetween(begin_, now);
    reading.p_M = {0, -kDepth * (1 - std::cos(phase)) / 2, 0};
    reading.v_M = {0, -std::numbers::pi * kDepth * std::sin(phase), 0};
    reading.engaged = is_engaged;
    if (is_faulty) reading.status.fault = DeviceFault::kDriver;
    return reading;
  }

 private:
  static constexpr double kDepth = 3e-3;  // [m]
  const Time begin_ = Clock::now();
};

// Checks that after a fault of the device there is no force before a new engagement.
class FaultCheck {
 public:
  void Add(const TickRecord& record) {
    if (record.device.fault != DeviceFault::kNone) faulty_epoch_ = record.epoch;
    if (!faulty_epoch_) return;
    if (record.state == OperatorState::kFollowing && record.epoch > *faulty_epoch_) {
      faulty_epoch_.reset();
    } else {
      EXPECT_EQ(record.chain.sent, Eigen::Vector3d(0, 0, 0));
    }
  }

 private:
  std::optional<std::uint32_t> faulty_epoch_;
};

class JoinedThreadsTest : public testing::Test {
 protected:
  JoinedThreadsTest() {
    link_.Start(&states_, &commands_, &settings_, true);
    haptics_ = std::jthread(
        [this](const std::stop_token& stop) { loop_.Run(hand_, std::chrono::hours(1), stop); });
  }
  // Reads the ticks as a session does.
  template <class Condition>
  bool Until(const Condition& condition) {
    return Eventually([&] {
      for (TickRecord record; records_.Pop(&record);) check_.Add(record);
      return condition();
    });
  }
  void For(double seconds) {
    const Time end = Clock::now() + Seconds(seconds);
    Until([&] { return Clock::now() >= end; });
  }

  // Resets the stop that the newest state shows.
  std::string Reset() { return link_.calls().Reset(link_.state().message->stops()); }
  // Makes the tool follow. Like a person, the operator resets a stop and engages again after a
  // hold.
  bool Follows() {
    const auto follows = [this] { return slave_.view().phase == Phase::kFollowing; };
    return Until([&] {
      if (follows()) return true;
      if (slave_.view().phase == Phase::kEstop) Reset();
      hand_.is_engaged = false;
      For(0.05);
      hand_.is_engaged = true;
      For(0.05);
      return follows();
    });
  }

  JoinedSlave slave_{[] { return Clock::now(); }};
  std::jthread sensing_{[this](const std::stop_token& stop) {
    for (int i = 0; !stop.stop_requested(); ++i) {
      if (i % 8 == 0) slave_.Sense();
      slave_.Watch();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }};
  Server server_{slave_, "127.0.0.1:0", false};
  LatestValue<ReceivedState> states_;
  LatestValue<OperatorCommand> commands_;
  LatestValue<RemoteSettings> settings_;
  SpscRing<TickRecord> records_{4096};
  HapticLoop loop_{{}, {&states_, &commands_, &records_, &settings_, nullptr, nullptr}};
  SlaveLink link_{{.target = server_.address(), .datagrams = true}};
  StopPath stops_{loop_.stops(),
                  {{},
                   [this] { return link_.calls().EmergencyStop("call"); },
                   [this] { link_.calls().GiveUpStop(); }}};
  Hand hand_;
  FaultCheck check_;
  std::jthread haptics_;
};

TEST_F(JoinedThreadsTest, StopsResetsSettingsAndFaultsLeaveEveryInvariantIntact) {
  ASSERT_TRUE(Until([&] { return slave_.view().phase == Phase::kClutched; }));
  ASSERT_TRUE(Follows());
  Dice dice(1);
  for (int round = 0; round < 40; ++round) {
    switch (dice.Whole(0, 4)) {
      case 0:
        loop_.stops().Request();
        break;
      case 1:
        link_.calls().EmergencyStop("another client");
        break;
      case 2:
        hand_.is_faulty = true;
        For(0.005);
        hand_.is_faulty = false;
        break;
      case 3:
        hand_.is_engaged = false;
        For(0.02);
        link_.calls().SetMapping(
            {.position_scale = dice.Between(0.5, 2), .force_scale = {}, .force_limit = {}});
        break;
      default:
        Reset();
    }
    hand_.is_engaged = false;
    For(0.02);
    hand_.is_engaged = true;
    For(0.03);
    // Another thread may be calling the stop at this time.
    EXPECT_TRUE(Until([&] {
      const bool is_stopped = slave_.view().phase == Phase::kEstop;
      return is_stopped == slave_.is_stop_recorded() && (is_stopped || !slave_.has_open_stop());
    }));
  }
  loop_.stops().Request();
  EXPECT_TRUE(Until([&] { return !loop_.stops().is_wanted(); }));
  EXPECT_EQ(slave_.view().phase, Phase::kEstop);
  // A stop call that is still in transit stops the tool once more.
  EXPECT_TRUE(Until([&] { return Reset().empty(); }));
  EXPECT_TRUE(Follows());
}

}  // namespace
}  // namespace palpate
