#include "master/session/recorder.h"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include "tests/support/scratch.h"

namespace palpate {
namespace {

const Time kStart{std::chrono::hours(1)};

class RecorderTest : public FolderTest {
 protected:
  [[nodiscard]] std::filesystem::path LogFile() const { return folder_ / "log.csv"; }
};

std::vector<std::string> Lines(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> Cells(const std::string& line) {
  std::vector<std::string> cells;
  std::string cell;
  std::istringstream in(line + ",");
  while (std::getline(in, cell, ',')) cells.push_back(cell);
  return cells;
}

TickRecord Record(int ms, double local) {
  TickRecord record;
  record.at = kStart + std::chrono::milliseconds(ms);
  record.state = OperatorState::kFollowing;
  record.chain.local = {0, local, 0};
  record.state_age = 0.002;
  return record;
}

// The true force comes with states, later than the ticks to which it belongs.
TEST_F(RecorderTest, WaitsForTheTrueForceOfEachTick) {
  SpscRing<TickRecord> ring(64);
  Recorder recorder(&ring, LogFile());
  for (int ms = 0; ms < 40; ++ms) {
    TickRecord record = Record(ms, 1.0);
    if (ms % 10 == 4) {  // sent 4 ms ago
      record.has_truth = true;
      record.truth_at = record.at - std::chrono::milliseconds(4);
      record.truth = {0, 0.05 * (ms - 4), 0};
    }
    ring.Push(record);
    recorder.Drain(record.at);
  }
  recorder.Finish();
  const auto lines = Lines(LogFile());
  ASSERT_EQ(lines.size(), 41U);
  const auto header = Cells(lines[0]);
  const auto column = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(header.begin(), header.end(), name) - header.begin());
  };
  ASSERT_LT(column("true_y"), header.size());
  EXPECT_EQ(Cells(lines[1 + 5])[column("true_y")], "0.25");
  EXPECT_EQ(Cells(lines[1 + 25])[column("true_y")], "1.25");
  EXPECT_EQ(Cells(lines[1 + 35])[column("true_y")], "") << "after the last truth";
  EXPECT_NEAR(recorder.summary().force_peak(), 1.5, 1e-12);
  // Reference: |1 - 0.05 k| for the ticks 0..30 that have a truth.
  double sum = 0;
  for (int k = 0; k <= 30; ++k) sum += std::pow(1 - 0.05 * k, 2);
  EXPECT_EQ(recorder.summary().force_error()->ticks, 31U);
  EXPECT_NEAR(recorder.summary().force_error()->rms, std::sqrt(sum / 31), 1e-12);
  EXPECT_NEAR(recorder.summary().force_error()->peak, 1, 1e-12);
}

// An operator who opens the clutch inside the object gets no force while the tool still presses.
// This is counted separately, since it is no error of the rendered force.
TEST(TickSummaryTest, SeparatesTheErrorOfReleasedHands) {
  TickSummary summary;
  const Eigen::Vector3d truth(0, 1, 0);
  summary.AddTruth(truth);
  TickRecord tick;
  tick.state = OperatorState::kFollowing;
  tick.chain.local = Eigen::Vector3d(0, 0.9, 0);
  for (int i = 0; i < 30; ++i) summary.Add(tick, truth);
  EXPECT_EQ(summary.let_go_ticks(), 0U);
  tick.state = OperatorState::kReady;
  for (int i = 0; i < 4; ++i) summary.Add(tick, truth);  // the force fades
  tick.chain.local.setZero();
  for (int i = 0; i < 7; ++i) summary.Add(tick, truth);
  summary.Close();
  EXPECT_EQ(summary.let_go_ticks(), 7U);
  EXPECT_EQ(summary.force_error()->ticks, 41U);
}

TEST_F(RecorderTest, TheLogHasTheContractsColumnsAndEmptyCellsForTheUnknown) {
  SpscRing<TickRecord> ring(64);
  Recorder recorder(&ring, LogFile());
  TickRecord record = Record(0, 0.25);
  record.chain.reasons.Add(Reason::kUnknown);
  record.chain.reasons.Add(Reason::kFading);
  ring.Push(record);
  recorder.Finish();
  const auto lines = Lines(LogFile());
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0],
            "t,state,p_M_x,p_M_y,p_M_z,p_S_x,p_S_y,p_S_z,estimated_x,estimated_y,estimated_z,"
            "local_x,local_y,local_z,scaled_x,scaled_y,scaled_z,passive_x,passive_y,passive_z,"
            "limited_x,limited_y,limited_z,sent_x,sent_y,sent_z,true_x,true_y,true_z,age_s,reason");
  EXPECT_EQ(lines[1],
            "0,FOLLOWING,0,0,0,0,0,0,,,,0,0.25,0,0,0,0,0,0,0,0,0,0,0,0,0,,,,0.002,unknown+fading");
}

// A stall of four seconds gives 4 MB in the ring, and would give 4 MB of ticks that wait for the
// true force.
TEST_F(RecorderTest, AfterAStallItsSecondsAreNotHeldASecondTime) {
  constexpr int kTicks = 4000;
  SpscRing<TickRecord> ring(4096);
  for (int ms = 0; ms < kTicks; ++ms) {
    TickRecord record = Record(ms, 1.0);
    record.has_truth = ms % 10 == 4;
    record.truth_at = record.at - std::chrono::milliseconds(4);
    ring.Push(record);
  }
  const std::size_t before = mallinfo2().uordblks;
  std::size_t most = before;
  Recorder recorder(&ring, LogFile(), [&](const TickRecord&) {
    most = std::max<std::size_t>(most, mallinfo2().uordblks);
  });
  recorder.Drain(kStart + std::chrono::milliseconds(kTicks));
  recorder.Finish();
  EXPECT_LT(most - before, 512U << 10);
  EXPECT_EQ(Lines(LogFile()).size(), 1U + kTicks);
}

}  // namespace
}  // namespace palpate
