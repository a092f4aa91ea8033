#include "master/trials/trial_runner.h"

#include <atomic>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "master/device/sim_hand.h"
#include "master/recording/export.h"
#include "master/recording/replay.h"
#include "master/recording/session_recording.h"
#include "master/session/session.h"
#include "tests/master/haptics/rig.h"
#include "tests/master/haptics/test_device.h"
#include "tests/support/eventually.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Trial MakeTrial(std::uint32_t number, const std::string& label, double force_scale,
                RenderMode render) {
  Trial trial;
  trial.label = MakeTrialLabel(number, label);
  trial.condition.label = label;
  trial.condition.seconds = 0.4;
  trial.condition.force_scale = force_scale;
  trial.condition.render = render;
  return trial;
}

// A virtual slave on a thread of its own, which accepts force scales.
class Lab {
 public:
  LatestValue<ReceivedState> states;
  LatestValue<OperatorCommand> commands;
  LatestValue<RemoteSettings> settings;
  std::vector<double> scales;  // that were set; read after the session

  TrialRunner::Slave Settings() {
    return {[this](const SlaveLink::Mapping& mapping) {
              scales.push_back(*mapping.force_scale);
              RemoteSettings changed;
              changed.transform.force_scale = *mapping.force_scale;
              changed.force_limit = 3;
              settings.Put(changed);
              return std::string();
            },
            [](const std::string&) { return std::string(); }};
  }

 private:
  VirtualSlave slave_{VirtualSlave::Options{}};
  std::jthread thread_{[this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      slave_.Step(Clock::now(), &commands, &states);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }};
};

// A device whose switch is closed, and which opens it twice a second.
class Tapping final : public TestDevice {
 public:
  DeviceReading Read(Time now) noexcept override {
    DeviceReading reading;
    const auto part = now.time_since_epoch() % std::chrono::milliseconds(500);
    reading.engaged = part > std::chrono::milliseconds(100);
    return reading;
  }
};

std::vector<std::vector<std::string>> Rows(const std::filesystem::path& file) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

// A whole session with log and recording. Each row and each recorded tick carries the label. Ticks
// in which the tool follows have the settings of their label.
TEST(TrialRunnerTest, EachTickOfLogAndRecordingCarriesTheLabel) {
  const Scratch scratch;
  const std::map<std::string, std::pair<double, RenderMode>> conditions{
      {"weak", {1, RenderMode::kLocal}}, {"strong", {2, RenderMode::kHold}}};
  Lab lab;
  Tapping device;
  OperatorRequests requests(RenderMode::kLocal);
  SessionRecording recording({.file = scratch / "s.mcap"});
  recording.Begin({{"trials", "t.csv"}});
  std::map<std::string, int> followed;
  std::vector<std::uint32_t> numbers;
  {
    TrialRunner runner(
        {MakeTrial(1, "strong", 2, RenderMode::kHold), MakeTrial(2, "weak", 1, RenderMode::kLocal),
         MakeTrial(3, "strong", 2, RenderMode::kHold)},
        &requests, lab.Settings());
    SessionOptions options;
    options.settings = &lab.settings;
    options.requests = &requests;
    options.log = scratch / "log.csv";
    options.has_trials = true;
    options.see_tick = [&](const TickRecord& tick) {
      runner.See(tick);
      recording.OnTick(tick);
      const std::string label(tick.trial.view());
      ASSERT_TRUE(conditions.contains(label));
      if (numbers.empty() || numbers.back() != tick.trial.number) {
        numbers.push_back(tick.trial.number);
      }
      if (tick.state != OperatorState::kFollowing) return;
      ++followed[label];
      EXPECT_EQ(tick.force_scale, conditions.at(label).first) << label;
      EXPECT_EQ(tick.render, conditions.at(label).second) << label;
    };
    options.duration = 60;
    RunSession(
        options, device, &lab.states, &lab.commands, [] { return LinkStats(); },
        [&] { return runner.is_over(); }, [](const Status&) {});
    EXPECT_EQ(runner.failure(), "");
  }
  recording.Finish();
  EXPECT_THAT(numbers, ElementsAre(1U, 2U, 3U));
  EXPECT_THAT(lab.scales, ElementsAre(2, 1, 2));
  EXPECT_GT(followed["weak"], 0) << "the tool followed in each condition";
  EXPECT_GT(followed["strong"], 0);

  const auto rows = Rows(scratch / "log.csv");
  ASSERT_GT(rows.size(), 1000U);
  ASSERT_EQ(rows[0][rows[0].size() - 2], "trial");
  ASSERT_EQ(rows[0].back(), "label");
  for (std::size_t i = 1; i < rows.size(); ++i) {
    ASSERT_EQ(rows[i].size(), rows[0].size()) << i;
    ASSERT_EQ(rows[i].back(), rows[i][rows[i].size() - 2] == "2" ? "weak" : "strong") << i;
  }
  std::size_t recorded = 0;
  ReplayFeed feed;
  feed.on_tick = [&](const TickRecord& tick) {
    ASSERT_EQ(tick.trial.view(), tick.trial.number == 2 ? "weak" : "strong");
    ++recorded;
  };
  Replay(scratch / "s.mcap").Play(0, 0, feed, {});
  EXPECT_EQ(recorded, rows.size() - 1) << "each row is recorded";
  ExportSession(scratch / "s.mcap", scratch / "out", {});
  const auto exported = Rows(scratch / "out/log.csv");
  ASSERT_EQ(exported.size(), rows.size());
  EXPECT_EQ(exported[0].back(), "label");
  EXPECT_EQ(exported.back().back(), "strong");
}

// Ticks by hand. The clutch is open during a change, and closed while the slave rejects it, so that
// the operator can retract.
TEST(TrialRunnerTest, WaitsForTheOperatorAndForTheSlave) {
  OperatorRequests requests(RenderMode::kLocal);
  std::atomic<int> asked{0};
  std::atomic<bool> clutched_when_asked{false};
  TrialRunner runner({MakeTrial(1, "a", 3, RenderMode::kLocal)}, &requests,
                     {[&](const SlaveLink::Mapping&) {
                        clutched_when_asked = requests.between_trials.load();
                        return std::string(++asked < 3 ? "the object is in contact" : "");
                      },
                      {}});
  TickRecord tick;
  tick.state = OperatorState::kFollowing;
  tick.force_scale = 1;
  runner.See(tick);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(asked, 0) << "an engaged operator is not interrupted";
  tick.state = OperatorState::kReady;
  runner.See(tick);
  ASSERT_TRUE(Eventually([&] { return asked == 1 && !requests.between_trials; }));
  EXPECT_TRUE(clutched_when_asked);
  ASSERT_TRUE(Eventually([&] { return asked == 3; }));
  EXPECT_THAT(runner.TakeNotices(), ElementsAre("trial a waits: the object is in contact"));
  EXPECT_TRUE(requests.between_trials) << "until the loop has the new scale";
  tick.force_scale = 3;
  runner.See(tick);
  ASSERT_TRUE(Eventually([&] { return !requests.between_trials; }));
  ASSERT_TRUE(Eventually([&] { return runner.is_over(); }));
  EXPECT_EQ(runner.failure(), "");
}

TEST(TrialRunnerTest, AValueThatTheSlaveDoesNotAcceptEndsTheSession) {
  OperatorRequests requests(RenderMode::kLocal);
  TrialRunner runner({MakeTrial(1, "a", 3, RenderMode::kLocal)}, &requests,
                     {[](const SlaveLink::Mapping&) {
                        return std::string("force_scale = 3: accepted is 1e-06 to 2");
                      },
                      {}});
  TickRecord tick;
  tick.state = OperatorState::kReady;
  runner.See(tick);
  ASSERT_TRUE(Eventually([&] { return runner.is_over(); }));
  EXPECT_THAT(runner.failure(), HasSubstr("trial a: force_scale = 3: accepted is"));
}

}  // namespace
}  // namespace palpate
