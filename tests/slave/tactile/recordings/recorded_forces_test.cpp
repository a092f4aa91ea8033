#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/tactile/recordings/recordings.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

// Electrode i reads 3000 + i, and 10 t more after the first second; t is the row's time.
struct TactileRows {
  double period = 0.01, from = 0;
  int count = 300;
  std::string prefix;
  std::string extra_header;
  std::string (*extra)(double t) = [](double) { return std::string(); };

  [[nodiscard]] std::string Text() const {
    std::ostringstream text;
    text << "rel_time_s," << prefix << "pac0," << prefix << "pdc";
    for (int e = 1; e <= 19; ++e) text << "," << prefix << "E" << e;
    text << extra_header << "\n";
    for (int i = 0; i < count; ++i) {
      const double t = from + period * i;
      text << t << ",2000,2400";
      for (int e = 1; e <= 19; ++e) text << "," << 3000 + e + (t > 1 ? 10 * t : 0);
      text << extra(t) << "\n";
    }
    return text.str();
  }
};

class RecordedForcesTest : public ::testing::Test {
 protected:
  RecordedForcesTest()
      : folder_(std::filesystem::path(BinaryPath()) / "test_training" /
                ::testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  std::string Write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  static std::vector<LabelledRecording> Read(const std::string& argument, std::string finger = "") {
    return ReadRecordedForces(ParseDataArgument(argument), {std::move(finger), 50});
  }
  // What reading complains of.
  static std::string Complaint(const std::string& argument, const std::string& finger = "") {
    try {
      Read(argument, finger);
    } catch (const std::exception& e) {
      return e.what();
    }
    return "nothing";
  }

  std::filesystem::path folder_;
};

// A wrench every 7 ms that grows by (1, 2, -3) N/s after the first second, on an offset.
std::string Wrench(double from, double to, const char* header = "rel_time_s,fx_N,fy_N,fz_N\n") {
  std::ostringstream text;
  text.precision(12);
  text << header;
  for (double t = from; t <= to; t += 0.007) {
    const double s = std::max(t - 1, 0.0);
    text << t << "," << 0.08 + s << "," << -0.04 + 2 * s << "," << -0.18 - 3 * s << "\n";
  }
  return text.str();
}

// The wrench is linear between its samples but at its kink: interpolation is exact there.
TEST_F(RecordedForcesTest, TheWrenchIsInterpolatedAndItsOffsetTakenOff) {
  const auto tactile = Write("a.csv", TactileRows().Text());
  const auto wrench = Write("w.csv", Wrench(0, 3));
  const auto recordings = Read(tactile + "+" + wrench);
  ASSERT_EQ(recordings.size(), 1U);
  const LabelledRecording& r = recordings[0];
  ASSERT_EQ(r.t.size(), 300U);
  EXPECT_EQ(r.begin, 0U);
  EXPECT_EQ(r.end, 300U);
  for (std::size_t i = 0; i < 300; ++i) {
    const double s = std::max(r.t[i] - 1, 0.0);
    if (std::abs(r.t[i] - 1) < 0.01) continue;
    EXPECT_NEAR(static_cast<double>(r.force[i].x()), s, 1e-6);
    EXPECT_NEAR(static_cast<double>(r.force[i].y()), 2 * s, 1e-6);
    EXPECT_NEAR(static_cast<double>(r.force[i].z()), -3 * s, 1e-6);
  }
}

TEST_F(RecordedForcesTest, RestValuesAreTakenOffEverySignal) {
  const auto recordings =
      Read(Write("a.csv", TactileRows().Text()) + "+" + Write("w.csv", Wrench(0, 3)));
  const LabelledRecording& r = recordings[0];
  EXPECT_EQ(r.change[10][4], 0);
  EXPECT_EQ(r.change[10][19], 0);
  EXPECT_NEAR(r.change[250][0], 25, 1e-3);
  EXPECT_NEAR(r.change[250][18], 25, 1e-3);
  EXPECT_EQ(r.change[250][20], 0);
}

TEST_F(RecordedForcesTest, ForceColumnsMayStandInTheTactileFile) {
  TactileRows rows;
  rows.extra_header = ",fx,fy,fz";
  rows.extra = [](double t) { return ",1,2," + std::to_string(t > 1 ? -4.0 : -1.0); };
  const auto recordings = Read(Write("a.csv", rows.Text()));
  EXPECT_NEAR(recordings[0].force[200].x(), 0, 1e-6);
  EXPECT_NEAR(recordings[0].force[200].z(), -3, 1e-6);
}

TEST_F(RecordedForcesTest, ASliceChoosesInstantsAndKeepsTheRestOfTheWholeFile) {
  const auto files = Write("a.csv", TactileRows().Text()) + "+" + Write("w.csv", Wrench(0, 3));
  const auto recordings = Read(files + "@1.5:2.25");
  const LabelledRecording& r = recordings[0];
  EXPECT_NEAR(r.t[r.begin], 1.5, 1e-9);
  EXPECT_NEAR(r.t[r.end], 2.25, 1e-9);
  EXPECT_NEAR(r.change[200][0], 20, 1e-3);
  EXPECT_NEAR(static_cast<double>(r.force[200].z()), -3, 1e-6);
  EXPECT_EQ(Read(files + "@1.5:")[0].end, 300U);
  EXPECT_EQ(Read(files + "@:0.8")[0].begin, 0U);
}

TEST_F(RecordedForcesTest, AGapCutsTheRecording) {
  const std::string first = TactileRows().Text();
  TactileRows later;
  later.from = 3.5;
  const std::string rest = later.Text();
  const auto tactile = Write("a.csv", first + rest.substr(rest.find('\n') + 1));
  const auto recordings = Read(tactile + "+" + Write("w.csv", Wrench(0, 7)));
  ASSERT_EQ(recordings.size(), 2U);
  EXPECT_NEAR(recordings[0].t.back(), 2.99, 1e-9);
  EXPECT_NEAR(recordings[1].t.front(), 3.5, 1e-9);
  EXPECT_EQ(recordings[1].t.size(), 300U);
}

TEST_F(RecordedForcesTest, SamplesAtAnotherRateAreResampled) {
  TactileRows rows;
  rows.period = 0.02;
  const auto recordings = Read(Write("a.csv", rows.Text()) + "+" + Write("w.csv", Wrench(0, 7)));
  ASSERT_EQ(recordings.size(), 1U);
  const LabelledRecording& r = recordings[0];
  for (std::size_t i = 1; i < r.t.size(); ++i) EXPECT_NEAR(r.t[i] - r.t[i - 1], 0.01, 1e-9);
  EXPECT_NEAR(r.t.back(), 5.98, 0.011);
  EXPECT_NEAR(r.change[401][0], 40.1, 1e-2);
}

TEST_F(RecordedForcesTest, OneFingerOfSeveralIsChosen) {
  TactileRows rows;
  rows.prefix = "rf_";
  const auto files = Write("a.csv", rows.Text()) + "+" + Write("w.csv", Wrench(0, 3));
  EXPECT_EQ(Read(files, "rf").size(), 1U);
  EXPECT_EQ(Read(files).size(), 1U);
  EXPECT_THAT(Complaint(files, "th"), HasSubstr("th"));
}

TEST_F(RecordedForcesTest, WhatIsWrongIsSaid) {
  const auto tactile = Write("a.csv", TactileRows().Text());
  EXPECT_THAT(Complaint(tactile), HasSubstr("no force columns"));
  EXPECT_THAT(Complaint(folder_ / "none.csv"), HasSubstr("none.csv"));
  EXPECT_THAT(Complaint(tactile + "+" + (folder_ / "none.csv").string()), HasSubstr("none.csv"));
  EXPECT_THAT(Complaint(tactile + "+" + Write("far.csv", Wrench(100, 103))),
              HasSubstr("do not overlap"));
  EXPECT_THAT(Complaint(tactile + "+" + Write("no.csv", "rel_time_s,tx\n0,1\n")),
              HasSubstr("no force columns"));
  EXPECT_THAT(Complaint(tactile + "+" + Write("nan.csv", "t,fx,fy,fz\n0,1,2,3\n1,1,nan,3\n")),
              HasSubstr("nan.csv:3"));
  EXPECT_THAT(Complaint(tactile + "+" + Write("back.csv", "t,fx,fy,fz\n1,1,2,3\n0,1,2,3\n")),
              HasSubstr("back.csv:3"));
  const auto wrench = Write("w.csv", Wrench(0, 3));
  EXPECT_THAT(Complaint(tactile + "+" + wrench + "@50:60"), HasSubstr("no samples between"));
  EXPECT_THAT(Complaint(tactile + "+" + wrench + "@2:1"), HasSubstr("FROM < TO"));
  EXPECT_THAT(Complaint(tactile + "+" + wrench + "@one:2"), HasSubstr("@FROM:TO"));
  TactileRows few;
  few.count = 20;
  EXPECT_THAT(Complaint(Write("few.csv", few.Text()) + "+" + wrench), HasSubstr("too few"));
}

TEST_F(RecordedForcesTest, AForceThatIsNoNumberIsToldWithItsCell) {
  TactileRows rows;
  rows.extra_header = ",fx,fy,fz";
  rows.extra = [](double t) { return std::string(t > 1.235 && t < 1.245 ? ",1,2,nan" : ",1,2,3"); };
  EXPECT_THAT(Complaint(Write("a.csv", rows.Text())),
              ::testing::EndsWith("a.csv:126: fz = nan: accepted is a finite number"));
}

TEST_F(RecordedForcesTest, TooSlowARecordingIsRefused) {
  TactileRows rows;
  rows.period = 0.2;
  EXPECT_THAT(Complaint(Write("a.csv", rows.Text()) + "+" + Write("w.csv", Wrench(0, 70))),
              ::testing::EndsWith("a.csv: 5 Hz: accepted is 25 Hz or more for 100 Hz"));
}

// The stamp of one sample comes 0.66 periods late.
TEST_F(RecordedForcesTest, ALateStampInventsNoSample) {
  std::string text = TactileRows().Text();
  text.replace(text.find("\n1.5,") + 1, 3, "1.5066");
  const auto recordings = Read(Write("a.csv", text) + "+" + Write("w.csv", Wrench(0, 3)));
  EXPECT_EQ(recordings[0].t.size(), 300U);
}

TEST_F(RecordedForcesTest, AColumnThatIsNotThereIsNamed) {
  TactileRows rows;
  rows.prefix = "rf_";
  std::string text = rows.Text();
  const std::string wrench = "+" + Write("w.csv", Wrench(0, 3));
  EXPECT_EQ(Read(Write("a.csv", text) + wrench)[0].missing_column, "");
  text.replace(text.find("rf_pdc"), 6, "other");
  EXPECT_EQ(Read(Write("b.csv", text) + wrench)[0].missing_column, "rf_pdc");
}

TEST_F(RecordedForcesTest, TwoFingersNeedAChoice) {
  std::ostringstream text;
  text << "t";
  for (const char* finger : {"ff", "rf"}) {
    for (int e = 1; e <= 19; ++e) text << "," << finger << "_E" << e;
  }
  text << "\n0";
  for (int i = 0; i < 38; ++i) text << ",3000";
  EXPECT_THAT(Complaint(Write("a.csv", text.str() + "\n")), HasSubstr("--finger"));
}

TEST(ParseDataArgumentTest, NamesAreTakenApart) {
  const DataArgument whole = ParseDataArgument("dir/a.csv+dir/w.csv@0:9.5");
  EXPECT_EQ(whole.tactile, "dir/a.csv");
  EXPECT_EQ(whole.wrench, "dir/w.csv");
  EXPECT_EQ(whole.from, 0);
  EXPECT_EQ(whole.to, 9.5);
  const DataArgument plain = ParseDataArgument("me@home/a.csv");
  EXPECT_EQ(plain.tactile, "me@home/a.csv");
  EXPECT_TRUE(std::isinf(plain.to));
  EXPECT_THROW(ParseDataArgument(""), std::invalid_argument);
  EXPECT_THROW(ParseDataArgument("a.csv+"), std::invalid_argument);
  EXPECT_THROW(ParseDataArgument("a.csv@"), std::invalid_argument);
  EXPECT_THROW(ParseDataArgument("a.csv@nan:3"), std::invalid_argument);
}

TEST_F(RecordedForcesTest, OverlapsAreFoundWithinAFile) {
  const auto files = Write("a.csv", TactileRows().Text()) + "+" + Write("w.csv", Wrench(0, 3));
  const auto early = Read(files + "@0:1.5"), late = Read(files + "@1.5:3"), all = Read(files);
  EXPECT_FALSE(Overlap(early[0], late[0]));
  EXPECT_TRUE(Overlap(early[0], all[0]));
  const auto other =
      Read(Write("b.csv", TactileRows().Text()) + "+" + Write("w.csv", Wrench(0, 3)));
  EXPECT_FALSE(Overlap(all[0], other[0]));
}

}  // namespace
}  // namespace palpate
