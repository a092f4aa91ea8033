// Tests when datagrams yield to the stream and when not.
#include <cmath>
#include <deque>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "shared/link/datagram_line.h"

namespace palpate {
namespace {

constexpr double kTick = 5e-3;  // period of the states [s]

// A link and its peer: feedback about received datagrams arrives a round trip later.
class PacedLine {
 public:
  std::function<bool()> loses = [] { return false; };
  std::function<double()> round_trip = [] { return 0.05; };
  bool stream_moves = true, counts = true;

  void Run(double seconds) {
    for (const double end = t_ + seconds; t_ < end; t_ += kTick) {
      const Time now = Time{} + Seconds(kStart + t_);
      if (stream_moves) pace.StreamMoves(now);
      if (pace.Allows(now)) {
        ++sent;
        if (!loses()) seen_ = {static_cast<std::uint64_t>(sent), seen_.received + 1};
      }
      const double trip = round_trip();
      feedback_.push_back({t_ + trip, counts ? seen_ : DatagramCount{}, trip});
      while (!feedback_.empty() && feedback_.front().at <= t_) {
        pace.AddFeedback(feedback_.front().seen, feedback_.front().trip, now);
        feedback_.pop_front();
      }
    }
  }

  DatagramPace pace;
  int sent = 0;

 private:
  static constexpr double kStart = 1e9;  // [s]
  struct LinkFeedback {
    double at;
    DatagramCount seen;
    double trip;
  };
  double t_ = 0;
  DatagramCount seen_;
  std::deque<LinkFeedback> feedback_;
};

class DatagramPaceTest : public testing::Test {
 protected:
  std::mt19937 random_{1};  // the same each time
  PacedLine line_;
};

TEST_F(DatagramPaceTest, AnAbsentPeerGetsFewDatagrams) {
  line_.round_trip = [] { return 1e9; };
  line_.Run(10);
  EXPECT_NEAR(line_.sent, DatagramPace::kMinShare * 10 / kTick, 2);
}

TEST_F(DatagramPaceTest, LossByChanceAndShakenTripsAreNoReason) {
  for (const double trip : {0.01, 0.1, 1.0, 5.0}) {
    PacedLine line;
    line.loses = [this] { return std::bernoulli_distribution(0.05)(random_); };
    line.round_trip = [this, trip] {
      return trip * std::uniform_real_distribution(0.8, 1.2)(random_);
    };
    for (double share = DatagramPace::kInitialShare; share < 1; share = line.pace.share()) {
      line.Run(0.1);
      ASSERT_GE(line.pace.share(), share) << trip;
    }
    for (int i = 0; i < 60; ++i) {
      line.Run(1);
      ASSERT_EQ(line.pace.share(), 1) << trip << " s, after " << i;
    }
  }
}

TEST_F(DatagramPaceTest, TheyYieldWhereManyAreLostAndComeBack) {
  line_.Run(5);
  line_.loses = [this] { return std::bernoulli_distribution(0.4)(random_); };
  line_.Run(10);
  EXPECT_EQ(line_.pace.share(), DatagramPace::kMinShare);
  line_.loses = [] { return false; };
  line_.Run(15);
  EXPECT_EQ(line_.pace.share(), 1);
}

TEST_F(DatagramPaceTest, TheyYieldWhereTripsWait) {
  line_.Run(5);
  line_.round_trip = [] { return 0.25; };
  line_.Run(7);
  EXPECT_EQ(line_.pace.share(), DatagramPace::kMinShare);
  line_.round_trip = [] { return 0.05; };
  line_.Run(15);
  EXPECT_EQ(line_.pace.share(), 1);
}

TEST_F(DatagramPaceTest, TheyYieldWhereTheStreamStalls) {
  line_.Run(5);
  line_.stream_moves = false;
  line_.Run(1);
  EXPECT_EQ(line_.pace.share(), 1) << "as after a loss";
  line_.Run(9);
  EXPECT_EQ(line_.pace.share(), DatagramPace::kMinShare);
  line_.stream_moves = true;
  line_.Run(15);
  EXPECT_EQ(line_.pace.share(), 1);
}

TEST_F(DatagramPaceTest, TheShareStaysInItsBoundsForAnyFeedback) {
  const double strange[] = {NAN, -1, 0, INFINITY, 1e-300, 1e300};
  std::uniform_int_distribution<std::uint64_t> any_count;
  std::uniform_int_distribution<std::size_t> any(0, std::size(strange) - 1);
  Time now = Time{} + Seconds(1e6);
  for (int i = 0; i < 20000; ++i) {
    now += Seconds(0.1);
    line_.pace.AddFeedback({any_count(random_), any_count(random_)}, strange[any(random_)], now);
    line_.pace.Allows(now);
    ASSERT_GE(line_.pace.share(), DatagramPace::kMinShare);
    ASSERT_LE(line_.pace.share(), 1);
  }
}

}  // namespace
}  // namespace palpate
