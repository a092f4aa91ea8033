// The force on a liver from clouds of its front, beside the published scheme, which is told the
// patch and errs by 6.6 % (../shared/data/liver_registration/README.md). Nobody tells us the patch.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

#include <gtest/gtest.h>

#include "slave/pipeline/organ/cloud_load.h"
#include "tests/slave/pipeline/organ/liver_sequences.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

// The linear set's modulus is not stated: forces are in its unit until one scale is fitted. Its
// Poisson's ratio is that of the smallest residuals (0.42 to 0.45 alike).
constexpr double kUnitModulus = 1e4, kLinearNu = 0.45;
constexpr double kNeoHookean = 4500, kNeoHookeanNu = 0.49;  // as published
constexpr std::size_t kScaleFrames = 3;

CloudLoad MakeLoad(double modulus, double nu, double range) {
  const liver::Liver liver = liver::ReadLiver("remeshed");
  return {liver.mesh,
          liver.held,
          {.young_modulus = modulus, .poisson_ratio = nu, .range = range, .seen = liver.seen}};
}

struct FrameResult {
  CloudForce force;
  Vector3d truth;
  double cpu_us = 0;
};

std::vector<FrameResult> FollowSequence(CloudLoad* load, const std::string& sequence,
                                        std::size_t most = 100) {
  std::vector<FrameResult> told;
  load->Reset();
  for (const auto& frame : liver::ReadSequence(sequence)) {
    if (told.size() == most) break;
    const std::clock_t start = std::clock();
    told.push_back({load->Fit(frame.cloud), frame.force, 0});
    told.back().cpu_us = 1e6 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  }
  return told;
}

// That makes the first forces fit best.
double ScaleOf(const std::vector<FrameResult>& told) {
  double product = 0, square = 0;
  for (std::size_t i = 0; i < kScaleFrames; ++i) {
    product += told[i].force.force_O.dot(told[i].truth);
    square += told[i].force.force_O.squaredNorm();
  }
  return product / square;
}

struct Score {
  double error = 0;                  // sum of relative errors
  int frames = 0, one = 0, two = 0;  // components within one and two sigma
  int valid = 0, wrong = 0;          // valid, of these beyond three sigma
  std::vector<double> cpu_us;        // but for the first frame
};

void Add(const std::vector<FrameResult>& told, double scale, Score* score) {
  for (const FrameResult& frame : told) {
    const Vector3d error = scale * frame.force.force_O - frame.truth;
    const Vector3d sigma = scale * frame.force.covariance_O.diagonal().cwiseSqrt();
    score->error += error.norm() / frame.truth.norm();
    ++score->frames;
    score->one += static_cast<int>((error.array().abs() <= sigma.array()).count());
    score->two += static_cast<int>((error.array().abs() <= 2 * sigma.array()).count());
    if (&frame != told.data()) score->cpu_us.push_back(frame.cpu_us);
    if (frame.force.validity != Validity::kValid) continue;
    ++score->valid;
    score->wrong += error.norm() > 3 * sigma.norm() ? 1 : 0;
  }
}

void Print(const std::string& name, Score score) {
  std::ranges::sort(score.cpu_us);
  std::printf(
      "%-14s mean error %5.1f %%, within 1 and 2 sigma %3.0f %3.0f %%, valid %2d of %2d, beyond "
      "three sigma of these %d; CPU a frame median %.0f us, worst %.0f us\n",
      name.c_str(), 100 * score.error / score.frames, 100.0 * score.one / 3 / score.frames,
      100.0 * score.two / 3 / score.frames, score.valid, score.frames, score.wrong,
      score.cpu_us[score.cpu_us.size() / 2], score.cpu_us.back());
}

Score RunAll(CloudLoad* load, const std::string& law, bool is_scaled) {
  Score all;
  double scale = is_scaled ? 0 : 1;
  for (const std::string& name : liver::Sequences(law)) {
    const auto told = FollowSequence(load, name);
    if (scale == 0) scale = ScaleOf(told);
    Score one;
    Add(told, scale, &one);
    Print(name, one);
    Add(told, scale, &all);
  }
  Print(law + ", all", all);
  return all;
}

// Direction and steadiness ask for no modulus. Tolerance: 2 degrees are 3.5 % of the force.
TEST(LiverRegistrationTest, DirectionOfTheFirstForces) {
  if (!liver::IsThere()) GTEST_SKIP() << "needs ../shared/data/liver_registration";
  CloudLoad load = MakeLoad(kUnitModulus, kLinearNu, 1);
  for (const FrameResult& frame : FollowSequence(&load, "linear/s2", 3)) {
    EXPECT_GT(frame.force.force_O.normalized().dot(frame.truth.normalized()),
              std::cos(2 * M_PI / 180));
    EXPECT_EQ(frame.force.validity, Validity::kValid) << frame.force.why;
  }
}

// Reference: the published scheme, told the patch: 6.6 %.
TEST(Long, ForcesOnALinearLiver) {
  if (!liver::IsThere()) GTEST_SKIP() << "needs ../shared/data/liver_registration";
  CloudLoad load = MakeLoad(kUnitModulus, kLinearNu, 1);  // the truth is linear at any size
  const Score all = RunAll(&load, "linear", true);
  EXPECT_LT(all.error / all.frames, 0.066);
  EXPECT_GE(all.two, 0.9 * 3 * all.frames);
  EXPECT_EQ(all.wrong, 0);
}

// Small strain does not hold there: what is told is right or doubted.
TEST(Long, ForcesOnANeoHookeanLiverAreRightOrDoubted) {
  if (!liver::IsThere()) GTEST_SKIP() << "needs ../shared/data/liver_registration";
  CloudLoad load = MakeLoad(kNeoHookean, kNeoHookeanNu, CloudLoad::Params{}.range);
  EXPECT_EQ(RunAll(&load, "neohookean", false).wrong, 0);
}

}  // namespace
}  // namespace palpate
