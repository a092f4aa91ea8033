// Tests a replay from the view of its page.
#include "master/station/replay_station.h"

#include <algorithm>
#include <filesystem>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "palpate/v1/telemetry.pb.h"

#include "master/recording/session_recording.h"
#include "shared/wire/state_message.h"
#include "tests/master/station/server/page_client.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

constexpr int kReplayTicks = 600;
constexpr Time kReplayBegin{std::chrono::seconds(1'700'000'000)};

TickRecord TickAt(int i) {
  TickRecord tick;
  tick.at = kReplayBegin + std::chrono::milliseconds(i);
  tick.state = OperatorState::kFollowing;
  tick.chain.sent = {0, 0.001 * i, 0};
  tick.marks = i >= 300 ? 1 : 0;
  tick.state_age = 0.001;
  tick.sensed_age = 0.010;
  tick.state_sequence = static_cast<std::uint64_t>(i / 100 + 1);
  tick.energy = 0.002 * i;
  return tick;
}

// When the sample of a state was taken, the slave's clock.
Time SensedAt(int state) {
  return kReplayBegin + Seconds(0.1 * state);
}

class ReplayStationTest : public testing::Test {
 protected:
  void SetUp() override {
    SessionRecording recording({.file = file_});
    recording.Begin({{"scene", "block"},
                     {"device", "a hand"},
                     {"force_limit_N", "2.5"},
                     {"version", "0.0.9+a"}});
    for (int i = 0; i < kReplayTicks; ++i) {
      if (i > 0 && i % 100 == 0) PutState(&recording, i / 100 + 1);
      recording.OnTick(TickAt(i));
    }
    v1::TraceUpdate traces;
    for (int i = 1; i <= kReplayTicks / 100; ++i) {
      ToProto(SampleTrace{40U + static_cast<unsigned>(i), SensedAt(i), SensedAt(i) + Seconds(0.001),
                          SensedAt(i) + Seconds(0.004), SensedAt(i) + Seconds(0.005)},
              traces.add_samples());
    }
    recording.OnObserved(traces);
  }
  void TearDown() override {
    line_.reset();
    player_ = {};
    std::filesystem::remove(file_);
  }
  static void PutState(SessionRecording* recording, int number) {
    SlaveState state;
    state.sequence = static_cast<std::uint64_t>(number);
    state.sensed_at = SensedAt(number);
    state.sent_at = SensedAt(number) + Seconds(0.007);
    auto message = std::make_shared<v1::SlaveState>();
    ToProto(state, message.get());
    recording->OnState({message, kReplayBegin + std::chrono::milliseconds(100 * (number - 1))});
  }
  void Open(double from, double speed) {
    replay_.emplace(file_);
    station_.emplace(&*replay_, ReplayStation::Options{
                                    {{"127.0.0.1", 0}, {}}, from, speed, "a.mcap", "0.1.0+b"});
    const std::string address = station_->address();
    const std::string host = address.substr(7, address.size() - 8);
    line_.emplace(ParseEndpoint(host));
    EXPECT_THAT(line_->Upgrade(host, "http://" + host), HasSubstr("101"));
    player_ = std::jthread([this](const std::stop_token& stop) { station_->Run(stop); });
  }
  // The next message of `kind` that `wanted` accepts; null: the line ended.
  Json Next(const std::string& kind, const std::function<bool(const Json&)>& wanted = {}) {
    while (const auto frame = line_->ReadFrame(kText)) {
      const Json message = Json::parse(frame->payload);
      if (message["kind"] == kind && (!wanted || wanted(message))) return message;
    }
    return nullptr;
  }
  static bool IsPaused(const Json& status) { return !status["replay"]["playing"].get<bool>(); }

  const std::filesystem::path file_ =
      std::filesystem::temp_directory_path() / ("replay." + std::to_string(getpid()) + ".mcap");
  std::optional<Replay> replay_;
  std::optional<ReplayStation> station_;
  std::optional<PageClient> line_;
  std::jthread player_;
};

// Reference: the recorded traces: 1 ms, 3 ms and 1 ms, then 2 ms until the state was sent.
TEST_F(ReplayStationTest, TheWayFromTheLightToTheHandIsReported) {
  Open(0, 4);
  Json status;
  do {
    status = Next("status");
    ASSERT_FALSE(status.is_null());
  } while (!IsPaused(status));
  const Json& trace = status["trace"];
  ASSERT_FALSE(trace.is_null());
  EXPECT_EQ(trace["sample"], 46);
  EXPECT_EQ(trace["state"], 6);
  EXPECT_NEAR(trace["t"].get<double>(), 0.5, 1e-6) << "of the first tick that went by it";
  EXPECT_NEAR(trace["sensing"].get<double>(), 0.003, 1e-6);
  EXPECT_NEAR(trace["wait"].get<double>(), 0.002, 1e-6);
  EXPECT_NEAR(trace["wire"].get<double>(), 0.002, 1e-6);
  EXPECT_NEAR(trace["total"].get<double>(), 0.010, 1e-6);
  EXPECT_NEAR(status["samples"].back()[10].get<double>(), 0.002 * (kReplayTicks - 1), 0.03);
}

TEST_F(ReplayStationTest, SendsTheTicksThatWereRecordedAndPausesAtTheEnd) {
  Open(0, 4);
  int sent = 0;
  Json status;
  do {
    status = Next("status");
    ASSERT_FALSE(status.is_null());
    const double t = status["t"];
    EXPECT_NEAR(status["tick"]["sent"]["y"].get<double>(), t, 1e-6);
    EXPECT_EQ(status["tick"]["marks"], t >= 0.2995 ? 1 : 0);
    ++sent;
  } while (!IsPaused(status));
  EXPECT_GE(sent, 3);
  EXPECT_NEAR(status["t"].get<double>(), 0.001 * (kReplayTicks - 1), 1e-9);
  EXPECT_EQ(status["replay"]["seconds"], 0.001 * (kReplayTicks - 1));
}

TEST_F(ReplayStationTest, PausesAndGoesWhereItIsSent) {
  Open(0, 0.1);
  line_->SendText(R"({"do":"replay","playing":false,"to":0.4})");
  const Json there = Next("status", [](const Json& status) { return status["t"] > 0.3; });
  EXPECT_NEAR(there["t"].get<double>(), 0.4, 0.011);
  EXPECT_TRUE(IsPaused(there));
  const auto run = there["replay"]["run"].get<int>();
  line_->SendText(R"({"do":"replay","to":0.1})");
  const Json back = Next("status", [](const Json& status) { return status["t"] < 0.3; });
  EXPECT_NEAR(back["t"].get<double>(), 0.1, 0.011);
  EXPECT_GT(back["replay"]["run"], run) << "what was drawn before is another place's";
  for (const Json& sample : back["samples"]) EXPECT_LE(sample[1], back["t"]);
}

// Before the first state there is no force.
TEST_F(ReplayStationTest, LaterDataAreNotShown) {
  Open(0.4, 0.1);
  line_->SendText(R"({"do":"replay","playing":false})");
  const Json later =
      Next("status", [](const Json& status) { return !status["slave_state"].is_null(); });
  ASSERT_FALSE(later.is_null());
  EXPECT_GE(std::stoi(later["slave_state"]["sequence"].get<std::string>()), 4);
  line_->SendText(R"({"do":"replay","to":0})");
  const auto run = later["replay"]["run"];
  const Json first =
      Next("status", [&run](const Json& status) { return status["replay"]["run"] > run; });
  ASSERT_FALSE(first.is_null());
  EXPECT_TRUE(first["slave_state"].is_null());
}

TEST_F(ReplayStationTest, CommandsThatMoveTheToolAreIgnored) {
  Open(0, 0.1);
  for (const char* command :
       {R"({"do":"stop"})", R"({"do":"reset"})", R"({"do":"set","force_scale":2})",
        R"({"do":"pointer","at":1,"p_M":[0,0,0],"engaged":true})", R"({"do":"tare"})",
        R"({"do":"clutch","on":false})", R"({"do":"mark"})"}) {
    line_->SendText(command);
    EXPECT_THAT(Next("refused")["text"].get<std::string>(), HasSubstr("this is a replay"))
        << command;
  }
}

}  // namespace
}  // namespace palpate
