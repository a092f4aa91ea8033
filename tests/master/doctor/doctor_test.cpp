#include "master/doctor/doctor.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stop_token>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "master/doctor/link_check.h"
#include "slave/service/server.h"
#include "tests/slave/service/fake_slave.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const Finding& Of(const Findings& findings, const std::string& what) {
  for (const Finding& finding : findings) {
    if (finding.what == what) return finding;
  }
  throw std::out_of_range(what);
}

PeriodicStats Bare(double late_us, std::uint64_t missed) {
  PeriodicStats bare;
  bare.ticks = 1000;
  bare.missed = missed;
  for (int i = 0; i < 1000; ++i) bare.wake_us.Add(late_us);
  return bare;
}

TEST(DoctorTest, ATimerIsRatedByPerceptibleDelays) {
  EXPECT_EQ(CheckTimer(Bare(20, 0)).grade, Grade::kGood);
  EXPECT_THAT(CheckTimer(Bare(20, 0)).advice, IsEmpty());
  EXPECT_EQ(CheckTimer(Bare(200, 0)).grade, Grade::kNote);
  EXPECT_EQ(CheckTimer(Bare(20, 1)).grade, Grade::kNote);
  EXPECT_EQ(CheckTimer(Bare(20, 30)).grade, Grade::kBad);
  EXPECT_EQ(CheckTimer(Bare(900, 0)).grade, Grade::kBad);
  EXPECT_THAT(CheckTimer(Bare(900, 0)).advice, Not(IsEmpty()));
}

TEST(DoctorTest, GovernorsAndClocksAreReadFromTheSystemFiles) {
  const Scratch scratch;
  const std::filesystem::path& sys = scratch.path();
  const auto write = [&](const char* file, const char* text) {
    std::filesystem::create_directories((sys / file).parent_path());
    std::ofstream(sys / file) << text << '\n';
  };
  EXPECT_THAT(Of(ExamineProcessors(sys), "governor").measured, HasSubstr("unknown"));
  write("devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance");
  write("devices/system/clocksource/clocksource0/current_clocksource", "tsc");
  EXPECT_EQ(Of(ExamineProcessors(sys), "governor").grade, Grade::kGood);
  EXPECT_EQ(Of(ExamineProcessors(sys), "clock").grade, Grade::kGood);
  write("devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave");
  write("devices/system/clocksource/clocksource0/current_clocksource", "hpet");
  EXPECT_THAT(Of(ExamineProcessors(sys), "governor").measured, HasSubstr("powersave"));
  EXPECT_THAT(Of(ExamineProcessors(sys), "governor").advice, HasSubstr("performance"));
  EXPECT_EQ(Of(ExamineProcessors(sys), "clock").grade, Grade::kNote);
}

LinkSample Line(double round_trip, double gap) {
  LinkSample line;
  line.version = "0.0.0+other";
  line.phase = "ready: no operator is engaged";
  line.states = 201;
  line.seconds = 200 * gap;
  for (int i = 0; i < 200; ++i) {
    line.gap_us.Add(1e6 * gap);
    line.round_trip_us.Add(1e6 * round_trip);
  }
  return line;
}

TEST(DoctorTest, GapsInWhichTheHandWouldBeReleasedAreBadAndTheKeyIsNamed) {
  const RemoteScene scene;
  LinkSample line = Line(0.01, 0.01);
  EXPECT_EQ(Of(CheckLink(line, scene), "states").grade, Grade::kGood);
  line.gap_us.Add(80e3);
  line.gaps_beyond = 1;
  const Finding gaps = Of(CheckLink(line, scene), "states");
  EXPECT_EQ(gaps.grade, Grade::kBad);
  EXPECT_THAT(gaps.advice, HasSubstr("dead_after: 120 ms"));
}

TEST(DoctorTest, ASlaveWithoutSamplesIsNoted) {
  LinkSample line = Line(0.01, 0.01);
  EXPECT_EQ(Of(CheckLink(line, RemoteScene()), "sensing").grade, Grade::kNote);
  line.age = 0.02;
  EXPECT_EQ(Of(CheckLink(line, RemoteScene()), "sensing").grade, Grade::kGood);
}

TEST(DoctorTest, DatagramsAreTriedAndTheSlaveIsLeftAsItWas) {
  FakeSlave slave;
  Server server(slave, "127.0.0.1:0", false);
  SlaveLink::Options options;
  options.target = server.address();
  EXPECT_EQ(CheckDatagrams(TryDatagrams(options, 20)).grade, Grade::kGood);
  EXPECT_FALSE(std::ranges::any_of(slave.commands(), &OperatorCommand::engaged));
  EXPECT_EQ(slave.ends(), 1);
}

// The measurements would take two minutes each. The time limit is far above the duration of a
// cancellation and far below two minutes.
TEST(DoctorTest, AnExaminationEndsWhenItIsAskedTo) {
  FakeSlave slave;
  Server server(slave, "127.0.0.1:0", false);
  SlaveLink::Options options;
  options.target = server.address();
  for (const bool line : {false, true}) {
    std::stop_source ends;
    const std::jthread soon([&ends] {
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
      ends.request_stop();
    });
    const Time begin = Clock::now();
    if (line) {
      ExamineLink(options, 120, ends.get_token());
    } else {
      ExamineTimer(120, ends.get_token());
    }
    EXPECT_LT(SecondsBetween(begin, Clock::now()), 60) << (line ? "line" : "timer");
  }
}

TEST(DoctorTest, NoAnswerIsAFindingWithAdvice) {
  SlaveLink::Options nobody;
  nobody.target = "127.0.0.1:1";
  nobody.wait = 0;
  const Findings findings = ExamineLink(nobody, 0.1);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].grade, Grade::kBad);
  EXPECT_THAT(findings[0].advice, HasSubstr("palpate-slave serve"));
}

}  // namespace
}  // namespace palpate
