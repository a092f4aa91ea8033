#include "slave/tactile/training/learn_pattern.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Cholesky>

#include "shared/geometry/symmetric_eigen.h"
#include "slave/tactile/pattern_check.h"
#include "slave/tactile/training/estimate_errors.h"

namespace palpate {
namespace {

using Signals = SignalPattern::Signals;
using Covariance = SignalPattern::Covariance;

constexpr double kLeastSize = 30;     // of signals that stand out of their noise [counts]
constexpr float kLeastForce = 0.02F;  // [N]
constexpr float kLargestForce = 3;    // signals of more bend; gentle hands are what counts [N]
constexpr std::size_t kKinds = 40;
constexpr std::size_t kFewest = 100 * kPatternSignals;  // per kind that is told apart
constexpr std::size_t kMost = 200'000;
constexpr int kByDirection = 12, kByLikelihood = 8;  // rounds
constexpr double kFloor = 2e-5;                      // of the variance, of unit signals
constexpr double kRidge = 1e-6;
constexpr std::size_t kTelling = 500;  // samples that tell the error of a kind

struct Lessons {
  std::vector<Signals> x;  // of unit length
  std::vector<int> kind;
  Eigen::Matrix<double, 3, kPatternSignals> force;
};

Lessons Gather(std::span<const LabelledRecording> recordings, std::span<const Window> windows) {
  Lessons lessons;
  Covariance by_force = Covariance::Zero();
  Eigen::Matrix<double, kPatternSignals, 3> with_force =
      Eigen::Matrix<double, kPatternSignals, 3>::Zero();
  const std::size_t stride = windows.size() / kMost + 1;
  for (std::size_t i = 0; i < windows.size(); i += stride) {
    const LabelledRecording& recording = recordings[windows[i].recording];
    const Eigen::Vector3f& force = recording.force[windows[i].last];
    const Signals x = PatternSignals(recording.change[windows[i].last]);
    const float size = force.norm();
    if (!(size > kLeastForce && size < kLargestForce && x.norm() > kLeastSize)) continue;
    lessons.x.push_back(x.normalized());
    by_force += x * x.transpose() / static_cast<double>(size * size);
    with_force += x * (force / (size * size)).cast<double>().transpose();
  }
  by_force.diagonal().array() += kRidge * by_force.trace();
  lessons.force = by_force.ldlt().solve(with_force).transpose();
  lessons.kind.assign(lessons.x.size(), 0);
  return lessons;
}

// Each lesson goes to the kind of least `cost`.
template <typename Cost>
void Assign(std::size_t kinds, const Cost& cost, Lessons* lessons) {
  for (std::size_t i = 0; i < lessons->x.size(); ++i) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < kinds; ++k) {
      const double here = cost(k, lessons->x[i]);
      if (here >= least) continue;
      least = here;
      lessons->kind[i] = static_cast<int>(k);
    }
  }
}

std::vector<SignalPattern::Kind> KindsOf(const Lessons& lessons, std::size_t kinds) {
  std::vector<SignalPattern::Kind> found(kinds, {0, Covariance::Zero()});
  for (std::size_t i = 0; i < lessons.x.size(); ++i) {
    SignalPattern::Kind& kind = found[static_cast<std::size_t>(lessons.kind[i])];
    kind.shape += lessons.x[i] * lessons.x[i].transpose();
    kind.share += 1;
  }
  for (SignalPattern::Kind& kind : found) {
    if (kind.share > 0) kind.shape /= kind.share;
    kind.shape.diagonal().array() += kFloor;
    kind.share /= static_cast<double>(lessons.x.size());
  }
  return found;
}

// Contacts whose signals point the same way, either way.
void SortByDirection(std::size_t kinds, Lessons* lessons) {
  std::vector<Signals> directions;
  for (std::size_t k = 0; k < kinds; ++k) {
    directions.push_back(lessons->x[k * lessons->x.size() / kinds]);
  }
  for (int round = 0; round < kByDirection; ++round) {
    Assign(
        kinds, [&](auto k, const Signals& x) { return -std::abs(directions[k].dot(x)); }, lessons);
    const auto found = KindsOf(*lessons, kinds);
    for (std::size_t k = 0; k < kinds; ++k) {
      directions[k] = EigenOf(found[k].shape).vectors.col(kPatternSignals - 1);
    }
  }
}

void SortByLikelihood(std::size_t kinds, Lessons* lessons) {
  for (int round = 0; round < kByLikelihood; ++round) {
    const auto found = KindsOf(*lessons, kinds);
    std::vector<Covariance> inverse;
    std::vector<double> offset;
    for (const SignalPattern::Kind& kind : found) {
      const Eigen::LLT<Covariance> factor(kind.shape);
      inverse.emplace_back(factor.solve(Covariance::Identity()));
      offset.push_back(2 * factor.matrixLLT().diagonal().array().log().sum() -
                       2 * std::log(kind.share));
    }
    Assign(
        kinds, [&](auto k, const Signals& x) { return x.dot(inverse[k] * x) + offset[k]; },
        lessons);
  }
}

}  // namespace

SignalPattern LearnPattern(std::span<const LabelledRecording> recordings,
                           std::span<const Window> windows) {
  Lessons lessons = Gather(recordings, windows);
  const std::size_t kinds = std::min(kKinds, lessons.x.size() / kFewest);
  if (kinds == 0) return {};
  SortByDirection(kinds, &lessons);
  SortByLikelihood(kinds, &lessons);
  SignalPattern pattern{KindsOf(lessons, kinds), lessons.force};
  std::erase_if(pattern.kinds, [](const SignalPattern::Kind& kind) { return !(kind.share > 0); });
  return pattern;
}

void LearnErrors(std::span<const LabelledRecording> recordings, std::span<const Window> windows,
                 std::span<const Eigen::Vector3f> estimated,
                 std::span<const Eigen::Vector3f> measured, SignalPattern* pattern) {
  if (!pattern->known()) return;
  std::vector<ErrorLawFit> fits(pattern->kinds.size());
  // Kinds as they are told in use, sample by sample.
  std::optional<PatternCheck> check;
  for (std::size_t i = 0, next = 0; i < windows.size(); ++i) {
    const LabelledRecording& recording = recordings[windows[i].recording];
    const bool goes_on = next > 0 && windows[i].recording == windows[i - 1].recording &&
                         windows[i].last > windows[i - 1].last;
    if (!goes_on) {
      check.emplace(*pattern, kNetworkRate);
      next = 0;
    }
    for (; next <= windows[i].last; ++next) check->Take(recording.change[next], {}, {}, 0);
    const auto square = static_cast<double>((estimated[i] - measured[i]).squaredNorm());
    const auto size = static_cast<double>(measured[i].norm());
    if (size > static_cast<double>(kLeastForce)) fits[check->kind()].Take(square, size);
  }
  for (std::size_t k = 0; k < fits.size(); ++k) {
    if (fits[k].count() >= kTelling) pattern->kinds[k].error = fits[k].law();
  }
}

}  // namespace palpate
