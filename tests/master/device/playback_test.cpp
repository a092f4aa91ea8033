#include "master/device/playback.h"

#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const Time kPlaybackStart{std::chrono::hours(1)};

Time PlaybackTime(double t) {
  return kPlaybackStart + Seconds(t);
}

std::filesystem::path Write(const std::string& text) {
  static const Scratch scratch;
  return scratch.Write("playback.csv", text);
}

std::string ErrorOf(const std::string& text) {
  return Thrown<std::runtime_error>([&] { const Playback playback(Write(text)); });
}

// Reference: a straight line is reproduced exactly by linear interpolation, at any rate of rows.
TEST(PlaybackTest, PlaysAStraightLineAtTrueTimeWithItsVelocity) {
  Playback playback(Write("note,z,time_s,y,x\nstart,0,5.0,1,0\n,0.2,5.1,1,-0.1\r\n,2,6,1,-1\n"));
  playback.Read(kPlaybackStart);
  for (const double t : {0.03, 0.1, 0.77, 0.999}) {
    const DeviceReading reading = playback.Read(PlaybackTime(t));
    EXPECT_NEAR(reading.p_M.x(), -t, 1e-9) << t;
    EXPECT_NEAR(reading.p_M.y(), 1, 1e-12) << t;
    EXPECT_NEAR(reading.p_M.z(), 2 * t, 1e-9) << t;
    EXPECT_NEAR((reading.v_M - Eigen::Vector3d(-1, 0, 2)).norm(), 0, 1e-12) << t;
    EXPECT_TRUE(reading.engaged);
    EXPECT_FALSE(playback.finished());
  }
}

TEST(PlaybackTest, EngagesAfterTheFirstReadingAndLetsGoAtTheEnd) {
  Playback playback(Write("time_s,x,y,z\n0,0,0,0\n0.5,0.1,0,0\n"));
  EXPECT_FALSE(playback.Read(kPlaybackStart).engaged);
  EXPECT_TRUE(playback.Read(PlaybackTime(0.001)).engaged);
  const DeviceReading last = playback.Read(PlaybackTime(0.5));
  EXPECT_FALSE(last.engaged);
  EXPECT_TRUE(playback.finished());
  EXPECT_EQ(last.p_M.x(), 0.1);
  EXPECT_EQ(last.v_M.norm(), 0);
  EXPECT_EQ(playback.Read(PlaybackTime(1e6)).p_M.x(), 0.1);
}

TEST(PlaybackTest, ErrorsStateFileLineAndWhatIsAccepted) {
  const std::string header = "time_s,x,y,z\n0,0,0,0\n";
  EXPECT_THAT(ErrorOf(""), HasSubstr("empty"));
  EXPECT_THAT(ErrorOf("time_s,x,z\n0,0,0\n"), AllOf(HasSubstr(".csv:1"), HasSubstr("column y")));
  EXPECT_THAT(ErrorOf("0,0,0,0\n1,0,0,0\n"), HasSubstr("a header row"));
  EXPECT_THAT(ErrorOf(header), HasSubstr("1 rows: expected at least 2"));
  EXPECT_THAT(ErrorOf(header + "0,1,1,1\n"), AllOf(HasSubstr(":3"), HasSubstr("time_s = 0")));
  EXPECT_THAT(ErrorOf(header + "1,nan,1,1\n"), AllOf(HasSubstr(":3"), HasSubstr("x = nan")));
  EXPECT_THAT(ErrorOf(header + "1,1,1e999,1\n"), HasSubstr("y = 1e999"));
  EXPECT_THAT(ErrorOf(header + "1,1,1\n"), HasSubstr("3 cells: expected 4"));
  EXPECT_THAT(ErrorOf(header + "1,1,1,2mm\n"), HasSubstr("z = 2mm"));
  EXPECT_THAT(ErrorOf(header + "1,1e30,0,0\n"), HasSubstr("position = 1e+30 m"));
}

// An operator's motion is about a metre at most, so 9 m must be in millimetres.
TEST(PlaybackTest, MillimetresAreConvertedWhereTheyAreNamedAndRefusedWhereNot) {
  EXPECT_THAT(ErrorOf("time_s,x,y,z\n0,0,0,0\n1,0,-9,0\n"),
              AllOf(HasSubstr(":3: position = 9 m"), HasSubstr("in mm it would be 0.009 m"),
                    HasSubstr("x (mm)")));
  Playback playback(Write("time_s,x (mm),y (mm),z (mm)\n0,0,0,0\n1,0,-9,0\n"));
  playback.Read(kPlaybackStart);
  EXPECT_DOUBLE_EQ(playback.Read(PlaybackTime(1)).p_M.y(), -0.009);
}

}  // namespace
}  // namespace palpate
