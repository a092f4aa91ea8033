// How fast bulk may go: a line of a given width and length, with a queue in front of it.
#include "slave/service/admission/bulk_pace.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr double kStep = 1e-3;     // [s]
constexpr double kWanted = 100e6;  // what the watchers would send [bytes/s]
constexpr double kRoom = 0.5;      // in the queue, then what comes is lost [s]

// A line that `pace` shares with an operator who hears a hundred states a second.
class Line {
 public:
  Line(double round_trip, double width) : round_trip_(round_trip), width_(width) {}

  void Run(double seconds) {
    for (const int end = step_ + static_cast<int>(seconds / kStep); step_ < end; ++step_) {
      queue_ = std::min(queue_ + std::min(pace_.Update(0, 0), kWanted) * kStep, kRoom * width_);
      const double sent = std::min(queue_, width_ * kStep);
      queue_ -= sent;
      sent_ += sent;
      waits_.push_back(queue_ / width_);
      if (step_ % 10 == 0) trips_.push_back(round_trip_ + waits_.back());
      if (step_ % 10 == 0 && static_cast<double>(trips_.size()) * 10 * kStep > round_trip_) {
        pace_.Hear(trips_.front());
        trips_.pop_front();
      }
      if (step_ % 50 == 49) pace_.Update(sent_ - std::exchange(told_, sent_), 50 * kStep);
    }
  }
  // Of what was waited since the last call, the share `quantile` waited less [s].
  double Waited(double quantile) {
    std::ranges::sort(waits_);
    return waits_[static_cast<std::size_t>(quantile * static_cast<double>(waits_.size() - 1))];
  }
  void Forget() {
    waits_.clear();
    sent_ = told_ = 0;
  }
  [[nodiscard]] double sent() const { return sent_; }
  void set_round_trip(double round_trip) { round_trip_ = round_trip; }

 private:
  BulkPace pace_;
  double round_trip_, width_;  // [s], [bytes/s]
  int step_ = 0;
  double queue_ = 0, sent_ = 0, told_ = 0;  // [bytes]
  std::deque<double> trips_;                // on their way
  std::vector<double> waits_;
};

using Length = double;
using Width = double;
class BulkPaceTest : public testing::TestWithParam<std::tuple<Length, Width>> {};

// Reference: without a pace the queue is as long as it can get, as it is when the operator comes.
// Bounds: a rate that grows by 5 % in a period P or round trip R makes a queue that is heard of a
// round trip later and judged at the end of the next period: 3 ms + R / 10, and 5 % of two of (P +
// R) on top.
TEST_P(BulkPaceTest, TheLineIsUsedAndItsQueueStaysShort) {
  const auto [round_trip, width] = GetParam();
  Line line(round_trip, width);
  line.Run(30);
  line.Forget();
  line.Run(30);
  EXPECT_LT(line.Waited(0.5), 1e-3);
  EXPECT_LT(line.Waited(1), 3e-3 + 0.1 * round_trip + 3 * 0.05 * 2 * (0.05 + round_trip));
  EXPECT_GT(line.sent(), 0.75 * 30 * width);
}

INSTANTIATE_TEST_SUITE_P(Lines, BulkPaceTest,
                         testing::Combine(testing::Values(0.001, 0.05),
                                          testing::Values(0.25e6, 2.5e6, 25e6)));

TEST(BulkPaceTest, NobodyIsPacedWhereNobodyOperates) {
  BulkPace pace;
  EXPECT_EQ(pace.Update(1e6, 0.05), BulkPace::kUnbound);
  pace.Hear(0.001);
  EXPECT_EQ(pace.Update(1e6, 0.05), BulkPace::kLeast);
  for (int i = 0; i < 120; ++i) pace.Update(1e6, 0.05);
  EXPECT_EQ(pace.Update(1e6, 0.05), BulkPace::kUnbound) << "6 s after the operator's last word";
}

TEST(BulkPaceTest, WhoSendsLittleIsNotTheCauseOfAQueue) {
  BulkPace pace;
  const auto decide = [&](double round_trip, double sent) {
    pace.Hear(round_trip);
    return pace.Update(sent * BulkPace::kPeriod, BulkPace::kPeriod);
  };
  for (int i = 0; i < 50; ++i) decide(0.001, 1e6);
  const double rate = decide(0.001, 1e6);
  ASSERT_GT(rate, 1e6);
  EXPECT_EQ(decide(0.1, 0.9 * BulkPace::kLeast), rate);
  EXPECT_LT(decide(0.1, 1e6), 0.9e6);
}

TEST(BulkPaceTest, ALineThatBecomesLongerIsUsedAgain) {
  Line line(0.001, 2.5e6);
  line.Run(20);
  line.set_round_trip(0.08);
  line.Run(40);
  line.Forget();
  line.Run(20);
  EXPECT_GT(line.sent(), 0.7 * 20 * 2.5e6);
}

TEST(BulkPaceTest, WhatIsNoRoundTripIsNotHeard) {
  BulkPace pace;
  pace.Hear(-1);
  pace.Hear(std::nan(""));
  EXPECT_EQ(pace.Update(1e6, 0.05), BulkPace::kUnbound);
}

}  // namespace
}  // namespace palpate
