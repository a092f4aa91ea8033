#include "master/recording/session_recording.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <random>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "palpate/v1/recording.pb.h"
#include "palpate/v1/teleoperation.pb.h"

#include "master/recording/replay.h"
#include "shared/text/text.h"
#include "shared/wire/fields.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

constexpr Time kSessionBegin{std::chrono::seconds(1'700'000'000)};

Eigen::Vector3d AnyTickVector(std::mt19937* random) {
  std::normal_distribution<double> number;
  return {number(*random), number(*random), number(*random)};
}

TickRecord AnyTick(std::mt19937* random, int i) {
  TickRecord tick;
  tick.at = kSessionBegin + std::chrono::milliseconds(i);
  tick.state = static_cast<OperatorState>(i % static_cast<int>(kOperatorStateCount));
  tick.p_M = AnyTickVector(random);
  tick.p_S = AnyTickVector(random);
  ForceChain& chain = tick.chain;
  chain.force_known = i % 5 != 0;
  if (chain.force_known) chain.estimated = AnyTickVector(random);
  for (auto* force : {&chain.local, &chain.scaled, &chain.passive, &chain.limited, &chain.sent}) {
    *force = AnyTickVector(random);
  }
  chain.reasons.Add(static_cast<Reason>(i % static_cast<int>(kReasonCount)));
  chain.reasons.Add(static_cast<Reason>((3 * i + 1) % static_cast<int>(kReasonCount)));
  tick.epoch = static_cast<std::uint32_t>(i / 7);
  tick.state_sequence = static_cast<std::uint64_t>(i / 3);
  tick.state_age = i % 11 == 0 ? -1 : 0.001 * i;
  if (tick.state_age >= 0) tick.sensed_age = tick.state_age + 0.02;
  tick.round_trip = i % 4 == 0 ? 0.0005 : 0;
  tick.marks = static_cast<std::uint32_t>(i / 50);
  if (i % 9 == 0) tick.tare = AnyTickVector(random);
  tick.energy = 1e-3 * i;
  if (i % 8 == 0) tick.torque = AnyTickVector(random);
  tick.has_truth = i % 6 == 0;
  if (!tick.has_truth) return tick;
  tick.truth = AnyTickVector(random);
  tick.truth_at = tick.at - std::chrono::nanoseconds(1234567);
  return tick;
}

// Seven digits are kept.
void ExpectNear(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  EXPECT_LE((a - b).norm(), 1e-6 * (1e-30 + b.norm())) << a.transpose() << ", " << b.transpose();
}

void ExpectSame(const TickRecord& read, const TickRecord& recorded) {
  EXPECT_EQ(read.at, recorded.at);
  EXPECT_EQ(read.state, recorded.state);
  ExpectNear(read.p_M, recorded.p_M);
  ExpectNear(read.p_S, recorded.p_S);
  EXPECT_EQ(read.chain.force_known, recorded.chain.force_known);
  ExpectNear(read.chain.estimated, recorded.chain.estimated);
  ExpectNear(read.chain.local, recorded.chain.local);
  ExpectNear(read.chain.scaled, recorded.chain.scaled);
  ExpectNear(read.chain.passive, recorded.chain.passive);
  ExpectNear(read.chain.limited, recorded.chain.limited);
  ExpectNear(read.chain.sent, recorded.chain.sent);
  EXPECT_EQ(ToString(read.chain.reasons), ToString(recorded.chain.reasons));
  EXPECT_EQ(read.epoch, recorded.epoch);
  EXPECT_EQ(read.state_sequence, recorded.state_sequence);
  EXPECT_FLOAT_EQ(static_cast<float>(read.state_age), static_cast<float>(recorded.state_age));
  EXPECT_FLOAT_EQ(static_cast<float>(read.sensed_age), static_cast<float>(recorded.sensed_age));
  EXPECT_EQ(read.marks, recorded.marks);
  ExpectNear(read.tare, recorded.tare);
  ExpectNear(read.torque, recorded.torque);
  EXPECT_FLOAT_EQ(static_cast<float>(read.energy), static_cast<float>(recorded.energy));
  EXPECT_EQ(read.has_truth, recorded.has_truth);
  ExpectNear(read.truth, recorded.truth);
  EXPECT_EQ(read.truth_at, recorded.truth_at);
}

class SessionRecordingTest : public FolderTest {
 protected:
  void Record(int ticks) {
    std::mt19937 random(3);
    SessionRecording recording({.file = file_});
    recording.Begin({{"scene", "block"}, {"force_limit_N", "3.3"}});
    for (int i = 0; i < ticks; ++i) {
      if (i % 3 == 0) {
        auto state = std::make_shared<v1::SlaveState>();
        state->set_sequence(static_cast<std::uint64_t>(i / 3));
        ToProto(kSessionBegin, state->mutable_sensed_at());
        ToProto(kSessionBegin, state->mutable_sent_at());
        state->mutable_p_s_tip();
        ToProto(Eigen::Vector3d(0, i, 0), state->mutable_force());
        state->set_sigma(0.25F);
        state->set_validity(v1::VALIDITY_EXTRAPOLATED);
        state->mutable_details()->set_score(0.5F);
        states_.push_back(state->SerializeAsString());
        recording.OnState({state, kSessionBegin + std::chrono::milliseconds(i)});
      }
      ticks_.push_back(AnyTick(&random, i));
      recording.OnTick(ticks_.back());
    }
  }

  const std::filesystem::path file_ = folder_ / "a.mcap";
  std::vector<TickRecord> ticks_;
  std::vector<std::string> states_;  // as received
};

TEST_F(SessionRecordingTest, ReplayGivesTheSameTicksInTheSameOrder) {
  Record(500);
  const Replay replay(file_);
  EXPECT_EQ(replay.span().ticks, ticks_.size());
  EXPECT_EQ(replay.span().session.at("scene"), "block");
  std::vector<TickRecord> read;
  std::vector<std::string> states;
  ReplayFeed feed;
  feed.on_tick = [&](const TickRecord& tick) { read.push_back(tick); };
  feed.on_state = [&](const SlaveState&, const v1::SlaveState& message) {
    states.push_back(message.SerializeAsString());
  };
  replay.Play(0, 0, feed, {});
  ASSERT_EQ(read.size(), ticks_.size());
  for (std::size_t i = 0; i < read.size(); ++i) ExpectSame(read[i], ticks_[i]);
  EXPECT_EQ(states.size(), 167U);
  EXPECT_EQ(states, states_) << "the bytes that arrived";
}

// Data that the slave sends once: its scene and the topology of its mesh.
TEST_F(SessionRecordingTest, EachPartContainsSceneAndTopology) {
  std::mt19937 random(3);
  {
    SessionRecording recording({.file = file_, .part = 0.02});
    v1::SceneDescription scene;
    scene.set_name("block");
    recording.OnObserved(scene);
    v1::MeshState mesh;
    mesh.set_nodes_per_element(2);
    for (const unsigned node : {0U, 1U}) mesh.add_elements(node);
    for (const float x : {0.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0.0F}) mesh.add_rest(x);
    *mesh.mutable_positions() = mesh.rest();
    recording.OnObserved(mesh);
    mesh.clear_elements();
    mesh.clear_rest();
    mesh.clear_nodes_per_element();
    for (int i = 0; !std::filesystem::exists(folder_ / "a-0003.mcap"); ++i) {
      recording.OnTick(AnyTick(&random, i));
      recording.OnObserved(mesh);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  int scenes = 0;
  std::shared_ptr<const RemoteMesh> newest;
  ReplayFeed feed;
  feed.on_scene = [&](const v1::SceneDescription& scene, Time) {
    EXPECT_EQ(scene.name(), "block");
    ++scenes;
  };
  feed.on_mesh = [&](const auto& mesh) { newest = mesh; };
  Replay(folder_ / "a-0002.mcap").Play(0, 0, feed, {});
  EXPECT_EQ(scenes, 1);
  ASSERT_TRUE(newest);
  EXPECT_EQ(newest->topology->lines.size(), 1U);
}

TEST_F(SessionRecordingTest, SwitchedOffItKeepsOnlySceneAndLog) {
  std::mt19937 random(3);
  {
    SessionRecording recording({.file = file_});
    for (int i = 0; i < 300; ++i) {
      if (i == 100 || i == 200) recording.Switch(i == 200);
      EXPECT_EQ(recording.is_on(), i < 100 || i >= 200);
      recording.OnTick(AnyTick(&random, i));
    }
  }
  std::vector<Time> ticks;
  std::vector<std::string> lines;
  ReplayFeed feed;
  feed.on_tick = [&](const TickRecord& tick) { ticks.push_back(tick.at); };
  feed.on_log = [&](const std::string& line, Time, bool) { lines.push_back(line); };
  Replay(file_).Play(0, 0, feed, {});
  ASSERT_EQ(ticks.size(), 200U);
  EXPECT_EQ(ticks[100] - ticks[99], std::chrono::milliseconds(101));
  EXPECT_THAT(lines, testing::IsSupersetOf({"recording is off from here", "recording is on"}));
}

TEST_F(SessionRecordingTest, AnAlarmWhoseNumbersChangeIsOneLine) {
  std::mt19937 random(3);
  {
    SessionRecording recording({.file = file_});
    recording.OnTick(AnyTick(&random, 0));
    for (const char* seconds : {"5", "6", "7"}) {
      v1::Status status;
      status.add_alarms("no sample for " + std::string(seconds) + " s");
      recording.OnObserved(status);
    }
    recording.OnTick(AnyTick(&random, 1));
  }
  std::vector<std::string> alarms;
  ReplayFeed feed;
  feed.on_log = [&](const std::string& line, Time, bool is_alarm) {
    if (is_alarm) alarms.push_back(line);
  };
  Replay(file_).Play(0, 0, feed, {});
  EXPECT_THAT(alarms, testing::ElementsAre("slave: no sample for 5 s"));
}

// An hour without a tick must be skipped, otherwise this test would not end.
TEST_F(SessionRecordingTest, TimesWithoutDataAreSkipped) {
  std::mt19937 random(3);
  {
    SessionRecording recording({.file = file_});
    for (const int i : {0, 1, 2, 3'600'000, 3'600'001}) recording.OnTick(AnyTick(&random, i));
  }
  int ticks = 0;
  ReplayFeed feed;
  feed.on_tick = [&](const TickRecord&) { ++ticks; };
  Replay(file_).Play(0, 1, feed, {});
  EXPECT_EQ(ticks, 5);
}

TEST_F(SessionRecordingTest, ReplayBeginsWhereItIsAskedTo) {
  Record(500);
  std::vector<TickRecord> read;
  ReplayFeed feed;
  feed.on_tick = [&](const TickRecord& tick) { read.push_back(tick); };
  Replay(file_).Play(0.25, 0, feed, {});
  ASSERT_EQ(read.size(), 250U);
  ExpectSame(read.front(), ticks_[250]);
}

}  // namespace
}  // namespace palpate
