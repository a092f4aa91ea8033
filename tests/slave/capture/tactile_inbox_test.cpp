// Tests the frames that result from live tactile streams of any kind.
#include "slave/capture/tactile_inbox.h"

#include <atomic>
#include <barrier>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

const Time kStart(std::chrono::hours(400'000));
Time At(double t) {
  return kStart + Seconds(t);
}

Tactile SceneTactile(const std::vector<std::string>& names, double rate = 100) {
  Tactile tactile;
  tactile.source = Tactile::Source::kStream;
  tactile.rate = rate;
  for (const auto& name : names) tactile.fingers.emplace_back().name = name;
  return tactile;
}

// Counts that encode their time: electrode i reads 1000 t + i.
FingerReading Reading(double t) {
  FingerReading reading;
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    reading.channels[i] = static_cast<float>(1000 * t + static_cast<double>(i));
  }
  reading.pac = static_cast<float>(-1000 * t);
  reading.pdc = static_cast<float>(2000 * t);
  return reading;
}
double TimeIn(const FingerReading& reading) {
  return static_cast<double>(reading.channels[0]) / 1000;
}

// Feeds inboxes as drivers would: sequences rise by themselves.
class Driver {
 public:
  Driver(TactileInbox* inbox, std::string finger, double clock = 0)
      : inbox_(inbox), finger_(std::move(finger)), clock_(clock) {}
  // A sample taken at `t` of the true time that arrives `delay` later. Empty: taken.
  std::string Send(double t, double delay = 0.002) {
    const auto refusal =
        inbox_->Feed(finger_, ++sequence_, At(t + clock_), Reading(t), At(t + delay));
    return refusal ? refusal->why : "";
  }

 private:
  TactileInbox* inbox_;
  std::string finger_;
  double clock_;  // offset of the sender's clock [s]
  std::uint64_t sequence_ = 0;
};

// Returns whether a thread of this process sleeps, see proc(5). A thread that waits for a processor
// does not count.
bool IsAsleep(pid_t thread) {
  std::ifstream stat("/proc/self/task/" + std::to_string(thread) + "/stat");
  const std::string text{std::istreambuf_iterator<char>(stat), {}};
  return text[text.rfind(')') + 2] == 'S';
}

// Takes all available frames.
std::vector<TactileFrame> TakeAll(TactileInbox* inbox) {
  std::vector<TactileFrame> frames;
  std::stop_source stop;
  std::atomic<int> taken{0};
  const std::jthread idle([&, taker = gettid()] {
    for (int seen = -1; seen != taken || !IsAsleep(taker);) {
      seen = taken;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    stop.request_stop();
  });
  while (const auto frame = inbox->Next(stop.get_token())) {
    frames.push_back(*frame);
    ++taken;
  }
  return frames;
}

TEST(TactileInboxTest, SamplesAtTheScenesRateAreTheFrames) {
  TactileInbox inbox(SceneTactile({"rf"}));
  Driver driver(&inbox, "rf");
  const double jitter[] = {0, 0.002, -0.002, 0.001};
  std::vector<double> times;
  for (int i = 0; i < 40; ++i) times.push_back(0.01 * i + jitter[i % 4]);
  for (const double t : times) EXPECT_EQ(driver.Send(t), "");
  const auto frames = TakeAll(&inbox);
  ASSERT_EQ(frames.size(), times.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].sequence, i + 1);
    EXPECT_EQ(frames[i].fingers[0].channels, Reading(times[i]).channels);
    EXPECT_EQ(frames[i].fingers[0].pac, Reading(times[i]).pac);
    EXPECT_EQ(frames[i].fingers[0].pdc, Reading(times[i]).pdc);
    EXPECT_TRUE(frames[i].fingers[0].present);
    EXPECT_FALSE(frames[i].fingers[1].present);
    EXPECT_FALSE(frames[i].after_gap);
    // The smallest delay counts as none.
    EXPECT_NEAR(SecondsBetween(At(times[i]), frames[i].sensed_at), 0.002, 1e-8);
  }
}

// Reference: counts are linear in time, so resampled ones encode their frame's time; the first
// delay of 2 ms counts as none. Tolerance: a float of 1000 counts rounds to 6e-5 counts, 6e-8 s.
class OtherRateTest : public ::testing::TestWithParam<double> {};

TEST_P(OtherRateTest, IsResampledToTheScenesRate) {
  TactileInbox inbox(SceneTactile({"rf"}));
  Driver driver(&inbox, "rf");
  std::vector<TactileFrame> frames;
  const int batch = 40;
  for (int i = 0; i < 4 * batch; ++i) {
    ASSERT_EQ(driver.Send(i / GetParam()), "");
    if (i % batch != batch - 1) continue;
    for (const auto& frame : TakeAll(&inbox)) frames.push_back(frame);
  }
  // Until the rate is known (0.3 s at most), samples may be used without alignment.
  std::size_t settled = frames.size();
  for (std::size_t i = 1; i < frames.size(); ++i) {
    EXPECT_NEAR(SecondsBetween(At(TimeIn(frames[i].fingers[0])), frames[i].sensed_at), 0.002, 1e-7);
    const double step = SecondsBetween(frames[i - 1].sensed_at, frames[i].sensed_at);
    const bool is_steady = std::abs(step - 0.01) < 1e-8 && !frames[i].after_gap;
    settled = is_steady ? std::min(settled, i) : frames.size();
  }
  EXPECT_LT(settled, 15U);
  const double duration = (4 * batch - 1) / GetParam();
  EXPECT_NEAR(static_cast<double>(frames.size()), 100 * duration, 30);
}

INSTANTIATE_TEST_SUITE_P(Rates, OtherRateTest,
                         ::testing::Values(20.0, 40.0, 71.0, 131.0, 200.0, 1000.0));

// Two senders whose clocks are a year apart and whose samples do not coincide.
TEST(TactileInboxTest, FingersMeetOnTheSlavesClock) {
  TactileInbox inbox(SceneTactile({"ff", "th"}));
  Driver ff(&inbox, "ff");
  Driver th(&inbox, "th", 3.2e7);
  for (int i = 0; i < 50; ++i) {
    ff.Send(0.01 * i, 0.001);
    th.Send(0.01 * i + 0.004, 0.001 + 0.001 * (i % 3));
  }
  const auto frames = TakeAll(&inbox);
  ASSERT_GE(frames.size(), 45U);
  for (std::size_t i = 5; i < frames.size(); ++i) {
    ASSERT_TRUE(frames[i].fingers[0].present && frames[i].fingers[1].present);
    EXPECT_NEAR(TimeIn(frames[i].fingers[0]), TimeIn(frames[i].fingers[1]), 1e-6);
    EXPECT_FALSE(frames[i].after_gap);
  }
}

TEST(TactileInboxTest, ASilentFingerIsAbsentAndReturnsAfterAGap) {
  TactileInbox inbox(SceneTactile({"ff", "th"}));
  Driver ff(&inbox, "ff");
  Driver th(&inbox, "th");
  std::vector<TactileFrame> frames;
  for (int i = 0; i < 60; ++i) {
    const bool ff_speaks = i < 20 || i >= 40;
    if (ff_speaks) ff.Send(0.01 * i);
    th.Send(0.01 * i);
  }
  frames = TakeAll(&inbox);
  ASSERT_EQ(frames.size(), 60U);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_TRUE(frames[i].fingers[1].present) << i;
    EXPECT_EQ(frames[i].fingers[0].present, i < 20 || i >= 40) << i;
    EXPECT_EQ(frames[i].after_gap, i == 40) << i;
  }
}

TEST(TactileInboxTest, AFewMissingSamplesAreFilled) {
  TactileInbox inbox(SceneTactile({"rf"}));
  Driver driver(&inbox, "rf");
  for (int i = 0; i < 30; ++i) {
    if (i != 12 && i != 20 && i != 21) driver.Send(0.01 * i);
  }
  const auto frames = TakeAll(&inbox);
  ASSERT_EQ(frames.size(), 30U);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_NEAR(TimeIn(frames[i].fingers[0]), 0.01 * static_cast<double>(i), 1e-6);
    EXPECT_FALSE(frames[i].after_gap);
  }
}

TEST(TactileInboxTest, WhatIsNotTakenIsReplacedByWhatIsNew) {
  TactileInbox inbox(SceneTactile({"rf"}));
  Driver driver(&inbox, "rf");
  driver.Send(0);
  EXPECT_EQ(TakeAll(&inbox).size(), 1U);
  for (int i = 1; i <= 5000; ++i) driver.Send(0.01 * i);
  const auto frames = TakeAll(&inbox);
  ASSERT_GE(frames.size(), 50U);
  ASSERT_LE(frames.size(), 100U);
  EXPECT_TRUE(frames.front().after_gap);
  EXPECT_NEAR(TimeIn(frames.back().fingers[0]), 50, 1e-5);
}

TEST(TactileInboxTest, PosesTravelWithTheSamples) {
  TactileInbox inbox(SceneTactile({"rf"}, 100));
  for (int i = 0; i < 3; ++i) {
    FingerReading reading = Reading(0.02 * i);
    reading.X_SF = Eigen::Translation3d(0.5 * i, 0, 0) *
                   Eigen::AngleAxisd(0.25 * std::numbers::pi * i, Eigen::Vector3d::UnitZ());
    ASSERT_FALSE(inbox.Feed("rf", 0, At(0.02 * i), reading, At(0.02 * i)));
  }
  const auto frames = TakeAll(&inbox);
  ASSERT_EQ(frames.size(), 5U);
  EXPECT_TRUE(frames[1].fingers[0].X_SF->translation().isApprox(Eigen::Vector3d(0.25, 0, 0), 1e-9));
  const Eigen::Vector3d x = frames[1].fingers[0].X_SF->linear().col(0);
  EXPECT_NEAR(std::atan2(x.y(), x.x()), 0.125 * std::numbers::pi, 1e-9);
}

TEST(TactileInboxTest, SaysWhatItRefuses) {
  TactileInbox inbox(SceneTactile({"ff", "th"}));
  ASSERT_FALSE(inbox.Feed("ff", 7, At(1), Reading(1), At(1)));
  const auto why = [&](const char* finger, std::uint64_t sequence, double t,
                       const FingerReading& reading) {
    const auto refusal = inbox.Feed(finger, sequence, At(t), reading, At(2));
    return refusal ? refusal->why : "taken";
  };
  EXPECT_EQ(why("rf", 8, 2, Reading(2)), "is not a finger of this scene: expected ff, th");
  EXPECT_THAT(why("ff", 8, 0.5, Reading(2)), HasSubstr("sensed_at: expected a time that does"));
  EXPECT_THAT(why("ff", 8, 0.5, Reading(2)), HasSubstr("decreased by 0.5"));
  EXPECT_EQ(why("ff", 7, 2, Reading(2)), "sequence = 7: expected one above the last, 7");
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1e30F}) {
    FingerReading reading = Reading(2);
    reading.channels[18] = bad;
    EXPECT_THAT(why("ff", 8, 2, reading), HasSubstr("electrode E19 = "));
    reading = Reading(2);
    reading.pac = bad;
    EXPECT_THAT(why("ff", 8, 2, reading), HasSubstr("pressure pac = "));
    reading = Reading(2);
    reading.pdc = bad;
    EXPECT_THAT(why("ff", 8, 2, reading), HasSubstr("pressure pdc = "));
  }
  FingerReading reading = Reading(2);
  reading.X_SF = Eigen::Isometry3d::Identity();
  reading.X_SF->translation().x() = std::nan("");
  EXPECT_THAT(why("ff", 8, 2, reading), HasSubstr("pose: expected"));
  reading.X_SF = Eigen::Isometry3d::Identity();
  reading.X_SF->matrix()(0, 0) = -1;  // a mirror
  EXPECT_THAT(why("ff", 8, 2, reading), HasSubstr("pose: expected"));
  EXPECT_EQ(why("ff", 8, 2, Reading(2)), "taken");  // nothing of it was used
}

TEST(TactileInboxTest, AfterOneHasLeftTheNextSendersClockStartsAgain) {
  TactileInbox inbox(SceneTactile({"rf"}));
  Driver first(&inbox, "rf", 1000);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(first.Send(0.01 * i), "");
  Driver second(&inbox, "rf", -1000);
  EXPECT_NE(second.Send(0.1), "");
  inbox.Leave("rf");
  inbox.Leave("nobody");
  Driver third(&inbox, "rf", -1000);
  for (int i = 10; i < 20; ++i) EXPECT_EQ(third.Send(0.01 * i), "");
  const auto frames = TakeAll(&inbox);
  ASSERT_EQ(frames.size(), 20U);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].after_gap, i == 10) << i;
    EXPECT_NEAR(SecondsBetween(At(TimeIn(frames[i].fingers[0])), frames[i].sensed_at), 0.002, 1e-6);
  }
}

TEST(TactileInboxTest, AFingerHasOneSenderUntilItIsSilentForASecond) {
  TactileInbox inbox(SceneTactile({"rf"}));
  const auto feed = [&](std::uint64_t sequence, double t, TactileInbox::SenderId sender) {
    const auto refusal = inbox.Feed("rf", sequence, At(t), Reading(t), At(t), sender);
    return refusal ? refusal->why : "taken";
  };
  for (std::uint64_t i = 1; i <= 20; ++i) {
    EXPECT_EQ(feed(i, 0.01 * static_cast<double>(i), 7), "taken");
  }
  EXPECT_THAT(feed(1, 0.21, 8), HasSubstr("is already fed by a stream: expected one stream"));
  inbox.Leave("rf", 8);  // another driver's finger
  EXPECT_EQ(feed(21, 0.22, 7), "taken");
  EXPECT_THAT(feed(1, 1.21, 8), HasSubstr("is already fed"));
  EXPECT_EQ(feed(1, 1.23, 8), "taken");  // independent of sequence and clock of the other driver
  EXPECT_THAT(feed(22, 1.24, 7), HasSubstr("is already fed"));
  inbox.Leave("rf", 8);
  EXPECT_EQ(feed(1, 1.25, 9), "taken");
}

// A sender with one sample per 0.9 s or with repeated samples does not keep the finger: the driver
// at 100 Hz is accepted within ten of its periods and stays.
TEST(TactileInboxTest, ARareSenderDoesNotBlockADriver) {
  TactileInbox inbox(SceneTactile({"rf"}));
  const auto takes = [&](double sensed, double t, TactileInbox::SenderId sender) {
    return !inbox.Feed("rf", 0, At(sensed), Reading(t), At(t), sender);
  };
  EXPECT_TRUE(takes(0, 0, 1));
  EXPECT_TRUE(takes(0.9, 0.9, 1));
  EXPECT_TRUE(takes(0.9, 0.99, 1)) << "the same again";
  EXPECT_FALSE(takes(0.95, 0.95, 2));
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(takes(1.01 + 0.01 * i, 1.01 + 0.01 * i, 2)) << i;
  EXPECT_FALSE(takes(2.2, 2.2, 1));
}

// Two drivers and a reader at once; also runs under the thread sanitizer.
TEST(TactileInboxTest, TwoThreadsFeedWhileOneReads) {
  TactileInbox inbox(SceneTactile({"ff", "th"}, 1000));
  std::stop_source stop;
  std::atomic<int> frames{0}, whole{0};
  std::jthread reader([&] {
    Time last{};
    while (const auto frame = inbox.Next(stop.get_token())) {
      EXPECT_GT(frame->sensed_at, last);
      last = frame->sensed_at;
      ++frames;
      whole += frame->fingers[0].present && frame->fingers[1].present;
    }
  });
  std::barrier<> together(2);
  const auto feed = [&](const char* finger) {
    Driver driver(&inbox, finger);
    for (int i = 0; i < 300; ++i) {
      EXPECT_EQ(driver.Send(0.001 * i), "");
      together.arrive_and_wait();
    }
  };
  {
    const std::jthread ff(feed, "ff");
    const std::jthread th(feed, "th");
  }
  while (frames < 300) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  stop.request_stop();
  reader.join();
  EXPECT_GE(whole, 299);  // the first frame may lack the finger whose driver came later
}

// For any order, delay, clock and rate: times increase, counts are finite, and no call blocks.
TEST(TactileInboxTest, ArbitraryStreamsGiveOrderedFiniteFrames) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  TactileInbox inbox(SceneTactile({"a", "b", "c"}));
  const char* names[] = {"a", "b", "c"};
  double sent[] = {0, 1e6, -1e6};
  double now = 0;
  Time last{};
  int taken = 0;
  for (int round = 0; round < 10; ++round) {
    for (int i = 0; i < 200; ++i) {
      const std::size_t k = random() % 3;
      const double u = uniform(random);
      sent[k] += u < 0.02 ? -0.5 : u < 0.05 ? 10 : u < 0.1 ? 0 : 0.02 * uniform(random);
      now += 0.005 * uniform(random);
      if (u > 0.99) inbox.Leave(names[k]);
      taken += !inbox.Feed(names[k], random() % 3, At(sent[k]), Reading(now), At(now));
    }
    for (const auto& frame : TakeAll(&inbox)) {
      EXPECT_GT(frame.sensed_at, last);
      last = frame.sensed_at;
      for (const auto& finger : frame.fingers) EXPECT_TRUE(std::isfinite(finger.channels[18]));
    }
  }
  EXPECT_GT(taken, 500);
  EXPECT_LT(taken, 2000);
}

TEST(TactileInboxTest, ASampleAllocatesNothing) {
  TactileInbox inbox(SceneTactile({"ff", "th"}));
  const FingerReading reading = Reading(1);
  const long before = AllocationCount();
  for (int i = 0; i < 1000; ++i) {
    inbox.Feed("ff", 0, At(0.01 * i), reading, At(0.01 * i));
    inbox.Feed("th", 0, At(0.01 * i), reading, At(0.01 * i));
    ASSERT_TRUE(inbox.Next({}));
  }
  EXPECT_EQ(AllocationCount() - before, 0);
}

// Reference: delays are 1 to 5 ms; the clock of the sender loses 100 us per second for an hour. The
// offset is remembered for 20 s, in which it changes by at most 2 ms.
TEST(SenderClockTest, FollowsAClockThatDrifts) {
  SenderClock clock;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> delay(0.001, 0.005);
  for (int i = 0; i < 36'000; ++i) {
    const double t = 0.1 * i;
    const double arrived = t + delay(random);
    const Time at = clock.Map(At(5000 + t * (1 - 1e-4)), At(arrived));
    ASSERT_LE(at, At(arrived)) << t;
    if (i <= 100) continue;
    ASSERT_NEAR(SecondsBetween(At(t), at), 0.0, 0.0035) << t;
  }
}

}  // namespace
}  // namespace palpate
