// A whole session in real time with the virtual slave, which runs on a separate thread.
#include "master/session/session.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include <gtest/gtest.h>

#include "tests/master/haptics/rig.h"
#include "tests/support/eventually.h"

namespace palpate {
namespace {

// Runs a slave in parallel to the session, until it is destroyed.
class Beside {
 public:
  LatestValue<ReceivedState> states;
  LatestValue<OperatorCommand> commands;
  VirtualSlave slave;

  explicit Beside(const VirtualSlave::Options& options = {}) : slave(options) {}

 private:
  std::jthread thread_{[this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      slave.Step(Clock::now(), &commands, &states);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }};
};

TEST(SessionTest, CountsEveryPeriodAndEndsWithTheForceAtZero) {
  Beside beside;
  Puppet puppet;
  puppet.force = {9, 9, 9};
  SessionOptions options;
  options.duration = 0.5;
  int shown = 0;
  const Report report = RunSession(
      options, puppet, &beside.states, &beside.commands, [] { return LinkStats(); },
      [] { return false; }, [&](const SessionStatus&) { ++shown; });
  // On any machine each period of the loop is either a tick or counted as missed.
  EXPECT_EQ(report.ticks + report.missed, std::llround(report.duration * 1000));
  EXPECT_GE(report.duration, options.duration - 1e-3);
  EXPECT_EQ(report.compute_us.count(), report.ticks);
  EXPECT_EQ(puppet.force.norm(), 0);
  EXPECT_GT(shown, 0);
  EXPECT_EQ(report.state, OperatorState::kReady);
  EXPECT_TRUE(report.truth_known);
}

// The thread that displays the session is waiting for another answer of the slave.
TEST(SessionTest, AStopDoesNotWaitForOtherCalls) {
  Beside beside;
  Puppet puppet;
  SessionOptions options;
  options.duration = 1;
  std::atomic<bool> wanted{true}, is_held{false};
  std::atomic<int> calls{0}, while_held{0};
  options.emergency = {[&] { return is_held && wanted.exchange(false); },
                       [&] {
                         while_held += is_held ? 1 : 0;
                         return ++calls == 3;  // the first two are lost
                       }};
  RunSession(
      options, puppet, &beside.states, &beside.commands, [] { return LinkStats(); },
      [] { return false; },
      [&](const SessionStatus&) {
        is_held = true;
        for (int i = 0; i < 5000 && calls < 3; ++i) {
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        is_held = false;
      });
  EXPECT_EQ(calls, 3);
  EXPECT_EQ(while_held, 3);
}

}  // namespace
}  // namespace palpate
