// Recordings of tactile samples: which are accepted, which are refused, and the resulting frames.
#include "slave/capture/tactile_recording.h"

#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/state/driven_clock.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

// E1 to E19 with `prefix`, comma-separated.
std::string ElectrodeColumns(const std::string& prefix, int count = kElectrodeCount) {
  std::string text;
  for (int i = 1; i <= count; ++i)
    text.append(i > 1 ? "," : "").append(prefix).append(std::to_string(i));
  return text;
}
// base + 1 to base + 19.
std::string Counts(double base) {
  std::string text;
  for (int i = 1; i <= kElectrodeCount; ++i) {
    text.append(i > 1 ? "," : "").append(std::to_string(base + i));
  }
  return text;
}
// One finger without a name, a sample at each of `times` whose counts encode its time: 1000 t + i.
std::string RecordingText(const std::vector<double>& times) {
  std::string text = "t,pac0,pdc," + ElectrodeColumns("E") + "\n";
  for (const double t : times) {
    text += std::to_string(t) + "," + std::to_string(1000 * t) + "," + std::to_string(2000 * t) +
            "," + Counts(1000 * t) + "\n";
  }
  return text;
}

TactileRecording Read(const std::string& text, const std::vector<std::string>& wanted = {}) {
  const Scratch scratch;
  return ReadTactileRecording(scratch.Write("touch.csv", text), wanted);
}

TEST(TactileRecordingTest, FingersComeInTheOrderWanted) {
  const std::string text = "# five were worn, two are here\n\nmf_pdc,time_s," +
                           ElectrodeColumns("mf_E") + "," + ElectrodeColumns("th_E") +
                           ",fx,remark\n" + "7,0.5," + Counts(100) + "," + Counts(200) +
                           ",-0.25,good\n";
  const auto both = Read(text, {"th", "mf"});
  ASSERT_EQ(both.fingers.size(), 2U);
  EXPECT_EQ(both.fingers[0].name, "th");
  EXPECT_FALSE(both.fingers[0].has_pdc);
  EXPECT_FLOAT_EQ(both.fingers[0].samples[0].channels[0], 201);
  EXPECT_TRUE(both.fingers[1].has_pdc);
  EXPECT_FALSE(both.fingers[1].has_pac);
  EXPECT_FLOAT_EQ(both.fingers[1].samples[0].pdc, 7);
  EXPECT_EQ(Read(text).fingers.size(), 2U);
  EXPECT_EQ(Read(text).fingers[0].name, "mf");
}

TEST(TactileRecordingTest, ColumnsOfAnotherDriverAreUnderstood) {
  const auto recording = Read("timestamp,pdc,pac1,pac2," + ElectrodeColumns("ele") + "\r\n" +
                              "1581073084.69,91,1211,1209," + Counts(0) + ",\r\n");
  EXPECT_DOUBLE_EQ(recording.t.at(0), 1581073084.69);
  EXPECT_FLOAT_EQ(recording.fingers.at(0).samples.at(0).pac, 1211);
  EXPECT_FLOAT_EQ(recording.fingers.at(0).samples.at(0).channels[18], 19);
}

struct BadRecording {
  const char* name;
  std::string text;
  std::vector<std::string> wanted;
  const char* message;
};

class BadRecordingTest : public ::testing::TestWithParam<BadRecording> {};

TEST_P(BadRecordingTest, IsRefusedWithItsLine) {
  EXPECT_THAT(Thrown<std::runtime_error>([] { Read(GetParam().text, GetParam().wanted); }),
              HasSubstr(std::string("touch.csv:") + GetParam().message));
}

const std::string kHead = "t," + ElectrodeColumns("E") + "\n";
const std::string kNamed = "t," + ElectrodeColumns("ff_E") + "," + ElectrodeColumns("rf_E") + "\n";

INSTANTIATE_TEST_SUITE_P(
    Files, BadRecordingTest,
    ::testing::Values(
        BadRecording{"Empty", "", {}, "1: empty: expected a CSV file with a header row"},
        BadRecording{"NoTime",
                     ElectrodeColumns("E") + "\n" + Counts(0) + "\n",
                     {},
                     "1: no time: expected a column rel_time_s, time_s, t_s, t, time or timestamp"},
        BadRecording{"ElectrodeMissing",
                     "t," + ElectrodeColumns("rf_E", 18) + "\n",
                     {"rf"},
                     "1: electrode rf_E19 is missing: expected rf_E1 to rf_E19"},
        BadRecording{"NoSuchFinger",
                     kNamed,
                     {"th"},
                     "1: finger = th: expected a finger of this recording: ff, rf"},
        BadRecording{"NotANumber",
                     kHead + "0,nan" + Counts(0).substr(8) + "\n",
                     {},
                     "2: E1 = nan: expected a finite number"},
        BadRecording{"ClockBack",
                     kHead + "0.02," + Counts(0) + "\n# here\n0.01," + Counts(0) + "\n",
                     {},
                     "4: t = 0.01: expected a time that increases from row to row, after 0.02"},
        BadRecording{"ClockInNanoseconds",
                     kHead + "1581073084690542596," + Counts(0) + "\n",
                     {},
                     "2: t = 1581073084690542596: expected a time in seconds"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(TactileRecordingTest, AnyNumberOfChannelsIsReadAndOthersAreRefused) {
  const Scratch scratch;
  const auto read = [&](const std::string& text, int count) {
    return ReadTactileRecording(scratch.Write("pad.csv", text), {}, {count, "kPa"});
  };
  const TactileRecording recording = read("t,c1 [kPa],c2 [kPa]\n0,1,2.5\n0.01,3,4\n", 2);
  ASSERT_EQ(recording.fingers.at(0).samples.size(), 2U);
  EXPECT_EQ(recording.fingers[0].samples[0].channels.size(), 2U);
  EXPECT_FLOAT_EQ(recording.fingers[0].samples[0].channels[1], 2.5F);
  const auto complaint = [&](const std::string& text) {
    return Thrown<std::runtime_error>([&] { read(text, 2); });
  };
  EXPECT_THAT(complaint("t,c1\n0,1\n"),
              HasSubstr("pad.csv:1: channel c2 is missing: expected c1 to c2"));
  EXPECT_THAT(complaint("t,c1,c2,c3\n0,1,2,3\n"),
              HasSubstr("pad.csv:1: channel c3: expected c1 to c2"));
  EXPECT_THAT(complaint("t,c0,c1,c2\n0,1,2,3\n"),
              HasSubstr("pad.csv:1: column c0: channels are counted from 1: expected c1"));
  EXPECT_THAT(complaint("t,c1 [Pa],c2 [Pa]\n0,1,2\n"),
              HasSubstr("pad.csv:1: column c1 [Pa]: expected c1 [kPa]"));
  EXPECT_THAT(complaint("t,c1,c2\n0,1,\n"), HasSubstr("pad.csv:2: c2 = "));
}

// --- frames

Scene SceneOf(const std::filesystem::path& file, double rate = 100) {
  Scene scene;
  scene.name = "recorded";
  Tactile tactile;
  tactile.file = file;
  tactile.rate = rate;
  tactile.fingers.resize(1);
  tactile.fingers[0].name = "rf";
  scene.sense.Set(tactile);
  return scene;
}

std::vector<TactileFrame> AllFrames(const Scene& scene) {
  const DrivenClock clock;
  const auto source = OpenTactileRecording(scene);
  std::vector<TactileFrame> frames;
  while (const auto frame = source->Next({})) frames.push_back(*frame);
  return frames;
}

TEST(RecordedTactileTest, SamplesAtAboutTheScenesRateAreTakenAsTheyAre) {
  const Scratch scratch;
  const std::vector<double> t{0.4, 0.4075, 0.42, 0.43, 0.44};
  const auto frames = AllFrames(SceneOf(scratch.Write("touch.csv", RecordingText(t))));
  ASSERT_EQ(frames.size(), t.size());
  for (std::size_t i = 0; i < t.size(); ++i) {
    EXPECT_EQ(frames[i].sequence, i + 1);
    EXPECT_NEAR(SecondsBetween(frames[0].sensed_at, frames[i].sensed_at), t[i] - t[0], 2e-9);
    EXPECT_FLOAT_EQ(frames[i].fingers[0].channels[0], static_cast<float>(1000 * t[i] + 1));
    EXPECT_FALSE(frames[i].fingers[0].X_SF);
  }
}

// The fingertip handles missing samples, which it detects by the timestamps.
TEST(RecordedTactileTest, PausesLongerThanThreePeriodsAreGaps) {
  const Scratch scratch;
  const std::vector<double> t{0, 0.01, 0.02, 0.049, 0.059, 0.1, 0.11};
  const auto frames = AllFrames(SceneOf(scratch.Write("touch.csv", RecordingText(t))));
  ASSERT_EQ(frames.size(), t.size());
  for (std::size_t k = 0; k < frames.size(); ++k) EXPECT_EQ(frames[k].after_gap, k == 5) << k;
}

// Reference: counts are 1000 t + i, so linear interpolation is exact to a float's rounding.
TEST(RecordedTactileTest, ResamplingIsLinearAndDoesNotBridgeGaps) {
  const Scratch scratch;
  const std::vector<double> t{0.5, 0.513, 0.529, 0.541, 0.56, 0.723, 0.736};
  const auto frames = AllFrames(SceneOf(scratch.Write("touch.csv", RecordingText(t)), 200));
  ASSERT_EQ(frames.size(), 16U);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const double at =
        k < 13 ? 0.5 + 0.005 * static_cast<double>(k) : 0.723 + 0.005 * static_cast<double>(k - 13);
    EXPECT_EQ(frames[k].sequence, k + 1);
    EXPECT_NEAR(SecondsBetween(frames[0].sensed_at, frames[k].sensed_at), at - 0.5, 2e-9);
    EXPECT_EQ(frames[k].after_gap, k == 13);
    EXPECT_NEAR(frames[k].fingers[0].channels[4], 1000 * at + 5, 1e-3);
    EXPECT_NEAR(frames[k].fingers[0].pdc, 2000 * at, 1e-3);
    EXPECT_FALSE(frames[k].fingers[1].present);
  }
}

// A pause of 31 years between two samples must not become 10^11 frames.
TEST(RecordedTactileTest, SamplesYearsApartAreRefused) {
  const Scratch scratch;
  EXPECT_THROW(AllFrames(SceneOf(scratch.Write("touch.csv", RecordingText({0, 1e9})))),
               std::runtime_error);
  EXPECT_EQ(AllFrames(SceneOf(scratch.Write("touch.csv", RecordingText({5})))).size(), 1U);
}

TEST(RecordedTactileTest, AStopEndsTheWait) {
  const Scratch scratch;
  std::vector<double> t;
  for (int i = 0; i < 20; ++i) t.push_back(0.9 * i);
  Scene scene = SceneOf(scratch.Write("touch.csv", RecordingText(t)), 1);
  const auto source = OpenTactileRecording(scene);
  ASSERT_TRUE(source->Next({}));
  std::stop_source stop;
  const std::jthread stopper([&stop] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    stop.request_stop();
  });
  EXPECT_FALSE(source->Next(stop.get_token()));
}

// --- poses

constexpr double kHalf = 0.70710678118654752;  // a quarter turn's quaternion

// Two samples of `rf` with poses, 0.02 s apart: the second one is moved and turned by a quarter.
std::string PosedRecording(const std::string& quaternion) {
  std::string head = "t", counts;
  for (int i = 1; i <= 19; ++i) head += ",rf_E" + std::to_string(i), counts += ",3000";
  return head + ",rf_x,rf_y,rf_z,rf_qw,rf_qx,rf_qy,rf_qz\n1" + counts + ",0,0,0.5,1,0,0,0\n1.02" +
         counts + ",0.25,0,0.5," + quaternion + "\n";
}

// Reference: half of a quarter turn about z is 45 degrees; the position is the midpoint.
TEST(RecordedPoseTest, LiesBetweenTheRecordedOnes) {
  const Scratch scratch;
  const std::string quarter = std::to_string(kHalf) + ",0,0," + std::to_string(kHalf);
  const auto frames = AllFrames(SceneOf(scratch.Write("touch.csv", PosedRecording(quarter))));
  ASSERT_EQ(frames.size(), 3U);  // resampled from 50 to 100 Hz
  const auto at = [&](std::size_t i) { return frames[i].fingers[0].X_SF.value(); };
  EXPECT_TRUE(at(0).translation().isApprox(Eigen::Vector3d(0, 0, 0.5), 1e-9));
  EXPECT_TRUE(at(1).translation().isApprox(Eigen::Vector3d(0.125, 0, 0.5), 1e-9));
  EXPECT_LT((at(1).linear() * Eigen::Vector3d::UnitX() - Eigen::Vector3d(kHalf, kHalf, 0)).norm(),
            1e-6);
  EXPECT_NEAR(at(2).linear().determinant(), 1, 1e-12);
}

TEST(RecordedPoseTest, MistakesAreRefusedWithTheirLine) {
  const Scratch scratch;
  const auto mistake = [&](const std::string& text) {
    const Scene scene = SceneOf(scratch.Write("touch.csv", text));
    return Thrown<std::runtime_error>([&] { OpenTactileRecording(scene); });
  };
  EXPECT_THAT(mistake(PosedRecording("1,1,0,0")),
              HasSubstr("touch.csv:3: qw,qx,qy,qz of length 1.414214: expected"));
  EXPECT_THAT(mistake(PosedRecording("nan,0,0,0")), HasSubstr("touch.csv:3: rf_qw = nan"));
  std::string incomplete = PosedRecording("1,0,0,0");
  incomplete.replace(incomplete.find("rf_qz"), 5, "other");
  EXPECT_THAT(mistake(incomplete), HasSubstr("touch.csv:1: column rf_qz is missing"));
}

// --- the real ones

class RealRecordingTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::is_directory(kData)) GTEST_SKIP() << kData << " is not here";
  }
  const std::filesystem::path kData = SourcePath("/../shared/data");
};

TEST_F(RealRecordingTest, RecordingsOfOtherLabsAreRead) {
  const auto pressed = ReadTactileRecording(kData / "biotac_contact_direction/trial1.csv", {});
  EXPECT_EQ(pressed.t.size(), 5185U);
  EXPECT_FALSE(pressed.fingers.at(0).has_pac);
  EXPECT_TRUE(pressed.fingers.at(0).has_pdc);
  const auto slid = ReadTactileRecording(kData / "biotac_slide/mat1_10_bio.csv", {});
  EXPECT_EQ(slid.t.size(), 600U);
  EXPECT_TRUE(slid.fingers.at(0).has_pac);
}

}  // namespace
}  // namespace palpate
