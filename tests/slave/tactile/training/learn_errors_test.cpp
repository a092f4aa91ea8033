#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "slave/tactile/training/learn_pattern.h"

namespace palpate {
namespace {

constexpr std::size_t kSamples = 800;  // of each kind
constexpr float kNewtons = 1;          // of each force

// Two kinds of contact: one moves the even electrodes alike, the other the odd ones.
SignalPattern::Signals SignalsOf(std::size_t kind) {
  SignalPattern::Signals x = SignalPattern::Signals::Zero();
  for (std::size_t e = kind; e < kElectrodeCount; e += 2) x[static_cast<Eigen::Index>(e)] = 100;
  return x;
}

SignalPattern TwoKinds() {
  SignalPattern pattern;
  for (std::size_t kind = 0; kind < 2; ++kind) {
    const SignalPattern::Signals u = SignalsOf(kind).normalized();
    SignalPattern::Covariance shape = u * u.transpose();
    shape.diagonal().array() += 1e-3;
    pattern.kinds.push_back({0.5, shape});
  }
  return pattern;
}

// Contacts of either kind by turns of fifty samples, whose forces are estimated wrong by `off`.
struct Lesson {
  explicit Lesson(float off_even, float off_odd) {
    for (std::size_t i = 0; i < 2 * kSamples; ++i) {
      const std::size_t kind = i / 50 % 2;
      const SignalPattern::Signals x = SignalsOf(kind);
      TactileSignals change{};
      for (std::size_t e = 0; e < kElectrodeCount; ++e) {
        change[e] = x[static_cast<Eigen::Index>(e)];
      }
      recording.t.push_back(0.01 * static_cast<double>(i));
      recording.change.push_back(change);
      recording.force.emplace_back(0, 0, -kNewtons);
      windows.push_back({0, i});
      measured.emplace_back(0, 0, -kNewtons);
      estimated.emplace_back(kind == 0 ? off_even : off_odd, 0, -kNewtons);
    }
    recording.end = recording.t.size();
  }
  void Learn(SignalPattern* pattern) const {
    LearnErrors({&recording, 1}, windows, estimated, measured, pattern);
  }
  LabelledRecording recording;
  std::vector<Window> windows;
  std::vector<Eigen::Vector3f> estimated, measured;
};

TEST(LearnErrorsTest, EachKindOfContactTellsItsOwn) {
  SignalPattern pattern = TwoKinds();
  Lesson(0.05F, 0.3F).Learn(&pattern);
  EXPECT_NEAR(pattern.kinds[0].error.At(kNewtons), 0.05, 1e-6);
  EXPECT_NEAR(pattern.kinds[1].error.At(kNewtons), 0.3, 1e-6);
}

TEST(LearnErrorsTest, EstimatesThatAreNoNumbersTellNothing) {
  SignalPattern pattern = TwoKinds();
  Lesson(std::numeric_limits<float>::quiet_NaN(), 0.3F).Learn(&pattern);
  EXPECT_FALSE(pattern.kinds[0].error.known());
  EXPECT_NEAR(pattern.kinds[1].error.At(kNewtons), 0.3, 1e-6);
}

TEST(LearnErrorsTest, FewContactsTellNothing) {
  SignalPattern pattern = TwoKinds();
  Lesson lesson(0.05F, 0.3F);
  lesson.windows.resize(300);
  lesson.Learn(&pattern);
  EXPECT_FALSE(pattern.kinds[0].error.known());
  EXPECT_FALSE(pattern.kinds[1].error.known());
}

}  // namespace
}  // namespace palpate
