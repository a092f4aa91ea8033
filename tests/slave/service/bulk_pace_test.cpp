// Tests the rate control of bulk data on a simulated link with given bandwidth, delay and queue.
#include "slave/service/bulk_pace.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr double kStep = 1e-3;  // [s]
constexpr Time kBegin = Time{} + std::chrono::hours(1);
constexpr double kWanted = 100e6;  // rate of data for the observers [bytes/s]
constexpr double kRoom = 0.5;      // capacity of the queue in time; further data is lost [s]

// A line that `pace` shares with an operator who receives a hundred states a second.
class Line {
 public:
  Line(double round_trip, double width) : round_trip_(round_trip), width_(width) {}

  void Run(double seconds) {
    for (const int end = step_ + static_cast<int>(seconds / kStep); step_ < end; ++step_) {
      const Time now = kBegin + Seconds(step_ * kStep);
      const double message = 0.4e-3 * width_;  // short against the queues in question
      for (double wanted = kWanted * kStep; wanted > 0 && pace_.Begin(message, now);
           wanted -= message) {
        queue_ = std::min(queue_ + message, kRoom * width_);
      }
      const double sent = std::min(queue_, width_ * kStep);
      queue_ -= sent;
      sent_ += sent;
      waits_.push_back(queue_ / width_);
      if (step_ % 10 == 0) trips_.push_back(round_trip_ + waits_.back());
      if (step_ % 10 == 0 && static_cast<double>(trips_.size()) * 10 * kStep > round_trip_) {
        pace_.AddRoundTrip("ada", trips_.front());
        trips_.pop_front();
      }
    }
  }
  // Quantile of the waiting times since the last call [s].
  double Waited(double quantile) {
    std::ranges::sort(waits_);
    return waits_[static_cast<std::size_t>(quantile * static_cast<double>(waits_.size() - 1))];
  }
  void Forget() {
    waits_.clear();
    sent_ = 0;
  }
  [[nodiscard]] double sent() const { return sent_; }
  void set_round_trip(double round_trip) { round_trip_ = round_trip; }

 private:
  BulkPace pace_;
  double round_trip_, width_;  // [s], [bytes/s]
  int step_ = 0;
  double queue_ = 0, sent_ = 0;  // [bytes]
  std::deque<double> trips_;     // in transit
  std::vector<double> waits_;
};

using Length = double;
using Width = double;
class BulkPaceTest : public testing::TestWithParam<std::tuple<Length, Width>> {};

// Reference: without rate control the queue is full, as when the operator connects. Bounds: a rate
// that grows by 5 % in a period P or a round trip R builds a queue that is detected one round trip
// later and evaluated at the end of the next period: 3 ms + R / 10, plus 5 % of 2 (P + R). Late
// streams send the data of 5 ms at once.
TEST_P(BulkPaceTest, TheLineIsUsedAndItsQueueStaysShort) {
  const auto [round_trip, width] = GetParam();
  Line line(round_trip, width);
  line.Run(30);
  line.Forget();
  line.Run(30);
  EXPECT_LT(line.Waited(0.5), 1e-3);
  EXPECT_LT(line.Waited(1), 8e-3 + 0.1 * round_trip + 3 * 0.05 * 2 * (0.05 + round_trip));
  EXPECT_GT(line.sent(), 0.75 * 30 * width);
}

INSTANTIATE_TEST_SUITE_P(Lines, BulkPaceTest,
                         testing::Combine(testing::Values(0.001, 0.05),
                                          testing::Values(0.25e6, 2.5e6, 25e6)));

// The rate of messages of 1 kB that are sent whenever they may be [bytes/s].
class Sender {
 public:
  // While the operator reports `round_trip` [s]; negative: none does. At most `most` [bytes/s].
  double Run(double seconds, double round_trip, double most = kWanted) {
    constexpr double kSize = 1000;
    double sent = 0;
    const Time begin = now_;
    for (; SecondsBetween(begin, now_) < seconds; now_ += Seconds(kStep)) {
      if (round_trip >= 0) pace_.AddRoundTrip("ada", round_trip);
      while (sent < most * SecondsBetween(begin, now_) && pace_.Begin(kSize, now_)) sent += kSize;
    }
    return sent / seconds;
  }

 private:
  BulkPace pace_;
  Time now_ = kBegin;
};

TEST(BulkPaceTest, WithoutAnOperatorThereIsNoLimit) {
  Sender sender;
  EXPECT_NEAR(sender.Run(1, -1), kWanted, 0.01 * kWanted);
  sender.Run(2 * BulkPace::kPeriod, 0.001);
  EXPECT_LT(sender.Run(1, 0.001), 3 * BulkPace::kMinRate) << "grows by 5 % in 50 ms at most";
  sender.Run(6, -1);
  EXPECT_NEAR(sender.Run(1, -1), kWanted, 0.01 * kWanted) << "6 s after the operator's last word";
}

TEST(BulkPaceTest, AStreamWithFewDataIsNotTheCauseOfAQueue) {
  Sender sender;
  sender.Run(3, 0.001);
  const double rate = sender.Run(0.2, 0.001);
  ASSERT_GT(rate, 5 * BulkPace::kMinRate);
  sender.Run(2, 0.1, 0.9 * BulkPace::kMinRate);
  EXPECT_GT(sender.Run(0.2, 0.001), 0.9 * rate);
  sender.Run(2, 0.1);
  EXPECT_LT(sender.Run(0.2, 0.1), 0.5 * rate);
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

TEST(BulkPaceTest, InvalidRoundTripsAreIgnored) {
  BulkPace pace;
  pace.AddRoundTrip("ada", -1);
  pace.AddRoundTrip("ada", std::nan(""));
  ASSERT_TRUE(pace.Begin(1e9, kBegin));
  EXPECT_TRUE(pace.Begin(1e9, kBegin + Seconds(1)));
}

}  // namespace
}  // namespace palpate
