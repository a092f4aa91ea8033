#include "slave/recording/recorded_run.h"

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "palpate/v1/recording.pb.h"

#include "shared/recording/mcap_writer.h"
#include "shared/recording/recording_reader.h"
#include "shared/text/text.h"
#include "slave/live/live_slave.h"
#include "slave/recording/sense_recording.h"
#include "slave/scene/scene_loader.h"
#include "tests/slave/simulator/simulated_devices.h"
#include "tests/support/not_finite.h"
#include "tests/support/paths.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A live slave on the shipped block is recorded once for all tests: its contact, its
// shape and a patch between images, given another modulus and another model, and restarted.
class RecordedRunTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::filesystem::temp_directory_path() / ("recorded-run." + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    const std::vector<std::string> overrides{"model.elements=60", "sense.camera.rate=30 Hz"};
    const Scene scene = LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"), overrides);
    SenseRecording recording(scene, overrides, {.file = folder_ / "slave.mcap"});
    const auto slave = MakeLiveSlave(scene, {}, &recording);
    const SimulatedDevices devices(scene, slave.get());
    Wait(*slave, 5);
    slave->SetParameters({.young_modulus = 2e5});
    Wait(*slave, 5);
    slave->SetModel({"bem2d"});
    slave->Reset(0);
    Wait(*slave, 5);
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(folder_); }

  static void Wait(Slave& slave, int images) {
    for (int i = 0; i < images; ++i) {
      const SlaveState state = slave.Compose(Clock::now());
      static_cast<void>(slave.Shape({.nodal_forces = i % 2 == 0}));
      static_cast<void>(slave.Patch());
      while (!slave.WaitForNewer(state.sensed_at, std::chrono::milliseconds(100))) {
      }
    }
  }

  // Copies the recording with each step modified by `change`, without the image of this number.
  static std::filesystem::path Changed(const std::function<void(v1::SenseStep*)>& change,
                                       int without_image = 0) {
    int images = 0;
    const auto file = folder_ / "changed.mcap";
    RecordingReader reader(folder_ / "slave.mcap");
    McapWriter writer(file, {.library = "test"});
    std::map<std::string, std::uint16_t, std::less<>> channels;
    while (reader.Next()) {
      if (channels.empty()) {
        for (const auto& a : reader.mcap().attachments()) writer.Attach(a.name, "", a.data, 0);
        for (const auto& [name, note] : reader.mcap().notes()) writer.Note(name, note);
      }
      const std::string topic(reader.topic());
      if (topic != kStepTopic && topic != kLeftTopic) continue;
      if (topic == kLeftTopic && ++images == without_image) continue;
      if (!channels.contains(topic)) {
        const auto id = static_cast<std::uint16_t>(topic == kStepTopic ? 1 : 2);
        channels[topic] = writer.AddChannel(topic, *reader.mcap().schema(id));
      }
      std::string bytes(reader.bytes());
      if (topic == kStepTopic) {
        v1::SenseStep step;
        reader.Read(&step);
        change(&step);
        bytes = step.SerializeAsString();
      }
      writer.Write(channels[topic], Nanoseconds(reader.at()), bytes);
    }
    return file;
  }
  static RecordedRun Process(const std::filesystem::path& file) {
    return ProcessRecording(file, folder_ / "out", {});
  }

  static inline std::filesystem::path folder_;
};

TEST_F(RecordedRunTest, EveryStateIsEstimatedAgainBitForBit) {
  const RecordedRun run = Process(folder_ / "slave.mcap");
  EXPECT_GE(run.differences.states, 15U);
  EXPECT_EQ(run.differences.different, 0U) << InWords(run)[1];
  EXPECT_THAT(run.damage, IsEmpty());
  EXPECT_EQ(run.version, run.version_now);
  std::ifstream states(folder_ / "out" / "states.csv");
  std::string line;
  std::uint64_t rows = 0;
  while (std::getline(states, line)) ++rows;
  EXPECT_EQ(rows, run.differences.states + 1);
}

TEST_F(RecordedRunTest, AStateThatDiffersIsNamedWithItsDifference) {
  std::uint64_t sample = 0;
  int estimates = 0;
  const auto file = Changed([&](v1::SenseStep* step) {
    if (!step->has_estimate() || ++estimates != 7) return;
    v1::SlaveState* state = step->mutable_estimate()->mutable_state();
    sample = step->estimate().sample();
    state->mutable_force()->set_y(state->force().y() + 0.125);
    state->mutable_p_s_tip()->set_x(state->p_s_tip().x() + 0.5);
  });
  const RecordedRun run = Process(file);
  EXPECT_EQ(run.differences.different, 1U);
  EXPECT_EQ(run.differences.first, sample);
  EXPECT_NEAR(run.differences.force, 0.125, 1e-12);
  EXPECT_NEAR(run.differences.tip, 0.5, 1e-12);
  EXPECT_THAT(InWords(run)[1], HasSubstr("1 differ from the recorded states, first at sample"));
}

TEST_F(RecordedRunTest, ARecordingThatIsCutIsProcessedAsFarAsItGoes) {
  const std::string bytes = ReadWholeFile(folder_ / "slave.mcap", 1 << 30, "a test's file");
  WriteWholeFile(folder_ / "cut.mcap", std::string_view(bytes).substr(0, bytes.size() * 2 / 3));
  const RecordedRun run = Process(folder_ / "cut.mcap");
  EXPECT_GT(run.differences.states, 0U);
  EXPECT_EQ(run.differences.different, 0U);
  EXPECT_THAT(run.damage, HasSubstr("it is truncated"));
}

// A recording with more data than could be written.
TEST_F(RecordedRunTest, ARecordingWithAGapIsProcessedUpToIt) {
  const auto whole = Process(folder_ / "slave.mcap").differences.states;
  const RecordedRun run = Process(Changed([](v1::SenseStep*) {}, 12));
  EXPECT_GT(run.differences.states, 0U);
  EXPECT_LT(run.differences.states, whole);
  EXPECT_EQ(run.differences.different, 0U);
  EXPECT_THAT(run.damage, HasSubstr("an image is missing"));
}

TEST_F(RecordedRunTest, ImpossibleStepsAreRefusedInWords) {
  const auto refusal = [](const std::filesystem::path& file) -> std::string {
    return Thrown<std::exception>([&] { Process(file); });
  };
  EXPECT_THAT(refusal(Changed([](v1::SenseStep* step) {
                if (step->has_acquired()) step->mutable_law();
              })),
              HasSubstr("a recorded estimate without its sample"));
  EXPECT_THAT(refusal(Changed([](v1::SenseStep* step) {
                if (step->has_estimate()) step->mutable_estimate()->mutable_p_s_arm()->set_x(kNan);
              })),
              HasSubstr("expected a finite number"));
  EXPECT_THAT(refusal(Changed([](v1::SenseStep* step) { step->mutable_law(); })),
              HasSubstr("no image received"));
}

}  // namespace
}  // namespace palpate
