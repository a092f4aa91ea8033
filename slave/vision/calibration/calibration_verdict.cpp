#include "slave/vision/calibration/calibration_verdict.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>

#include <fmt/format.h>

#include "slave/vision/calibration/robust_fit.h"

namespace palpate {
namespace {

// Fisher-Yates with an engine whose numbers are the same everywhere; std::shuffle's are not.
Indices Shuffled(Indices order, std::mt19937* random) {
  for (std::size_t i = order.size() - 1; i > 0; --i) {
    std::swap(order[i], order[(*random)() % (i + 1)]);
  }
  return order;
}

// Pictures whose corners all lie near those of the group's first one: by 1 % of the image's
// width, root mean square.
std::vector<Indices> GroupsOf(const std::vector<const Corners*>& views, int width) {
  constexpr double kAlike = 0.01;
  const auto is_alike = [&](const Corners& a, const Corners& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).ddot(a[i] - b[i]);
    return std::sqrt(sum / static_cast<double>(a.size())) < kAlike * width;
  };
  std::vector<Indices> groups;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto like = std::find_if(groups.begin(), groups.end(), [&](const Indices& group) {
      return is_alike(*views[i], *views[group.front()]);
    });
    if (like == groups.end()) {
      groups.push_back({i});
    } else {
      like->push_back(i);
    }
  }
  return groups;
}

Indices Members(const std::vector<Indices>& groups, const Indices& which) {
  Indices members;
  for (const std::size_t k : which) {
    members.insert(members.end(), groups[k].begin(), groups[k].end());
  }
  return members;
}

// `estimate`: from some of the images; throws std::runtime_error where it cannot.
HalvesCheck Halve(const std::vector<Indices>& groups, double whole,
                  const std::function<double(const Indices&)>& estimate) {
  HalvesCheck out;
  const std::size_t count = out.distinct = groups.size();
  if (count < kFewestForHalves) return out;
  const auto disagreement = [&](const Indices& a, const Indices& b) {
    try {
      return std::abs(estimate(Members(groups, a)) - estimate(Members(groups, b))) / whole;
    } catch (const std::runtime_error&) {
      ++out.failed;
      return 1.0;  // as wrong as can be reported
    }
  };
  Indices odd, even, all(count);
  std::iota(all.begin(), all.end(), std::size_t{0});
  for (const std::size_t i : all) (i % 2 == 0 ? odd : even).push_back(i);
  out.odd_even = disagreement(odd, even);
  std::mt19937 random(20);
  for (int k = 0; k < kRandomHalves; ++k) {
    const Indices order = Shuffled(all, &random);
    const auto middle = order.begin() + static_cast<std::ptrdiff_t>(count / 2);
    out.random.push_back(
        disagreement(Indices(order.begin(), middle), Indices(middle, order.end())));
  }
  std::sort(out.random.begin(), out.random.end());
  return out;
}

template <typename View>
std::vector<View> Chosen(const std::vector<View>& views, const Indices& which) {
  std::vector<View> chosen;
  for (const std::size_t i : which) chosen.push_back(views[i]);
  return chosen;
}

std::string Percent(double ratio) {
  return ratio < 0.995 ? fmt::format("{:.2g} %", 100 * ratio)
                       : fmt::format("{:.0f} %", 100 * ratio);
}

// Limits, and from where on one is warned.
constexpr double kSigma = 0.01, kSigmaWarned = 0.005;      // of baseline or focal length
constexpr double kResidual = 1.0, kResidualWarned = 0.5;   // [px]
constexpr double kCoverage = 0.15, kCoverageWarned = 0.4;  //
constexpr double kFocal = 0.02;                            // sigma, relative
constexpr double kUsed = 0.5;                              // of the pairs that show the board

}  // namespace

double HalvesCheck::sigma() const {
  double sum = odd_even * odd_even;
  for (const double d : random) sum += d * d;
  return 0.5 * std::sqrt(sum / static_cast<double>(random.size() + 1));
}

double HalvesCheck::worst() const {
  return random.empty() ? odd_even : std::max(odd_even, random.back());
}

HalvesCheck CheckHalves(const Board& board, const std::vector<PairView>& pairs,
                        const StereoRig& rig) {
  std::vector<const Corners*> lefts;
  for (const PairView& pair : pairs) lefts.push_back(&pair.left);
  const auto groups = GroupsOf(lefts, rig.left.size[0]);
  return Halve(groups, rig.baseline(), [&](const Indices& half) {
    return RefinePair(board, Chosen(pairs, half), rig).baseline();
  });
}

HalvesCheck CheckHalves(const Board& board, const std::vector<Corners>& views,
                        const std::array<int, 2>& size, double focal) {
  std::vector<const Corners*> all;
  for (const Corners& view : views) all.push_back(&view);
  return Halve(GroupsOf(all, size[0]), focal, [&](const Indices& half) {
    const Lens lens = CalibrateLens(board, Chosen(views, half), size).lens;
    return std::sqrt(lens.fx * lens.fy);
  });
}

double CoverageOf(const std::vector<Corners>& views, const std::array<int, 2>& size) {
  constexpr int kColumns = 8, kRows = 6;
  std::set<std::pair<int, int>> covered;
  for (const Corners& view : views) {
    for (const cv::Point2f& p : view) {
      const int i = static_cast<int>(p.x * kColumns / static_cast<float>(size[0]));
      const int j = static_cast<int>(p.y * kRows / static_cast<float>(size[1]));
      covered.emplace(std::clamp(i, 0, kColumns - 1), std::clamp(j, 0, kRows - 1));
    }
  }
  return static_cast<double>(covered.size()) / (kColumns * kRows);
}

CalibrationVerdict EvaluateCalibration(const CalibrationEvidence& question) {
  CalibrationVerdict verdict;
  const auto judge = [&](bool refused, bool warned, const std::string& words) {
    if (refused) {
      verdict.reasons.push_back(words);
    } else if (warned) {
      verdict.warnings.push_back(words);
    }
  };
  const HalvesCheck& halves = question.halves;
  if (halves.random.empty()) {
    verdict.reasons.push_back(
        fmt::format("{} different {} are too few to check the repeatability of the {}: expected "
                    "{} or more, each with another position of the board",
                    halves.distinct, question.things, question.quantity, kFewestForHalves));
  } else {
    judge(!(halves.sigma() <= kSigma), halves.sigma() > kSigmaWarned,
          fmt::format("halves of the images differ in the {} by {} (odd and even) and up to {} "
                      "(random halves): one sigma from all images is {}, expected at most {}",
                      question.quantity, Percent(halves.odd_even), Percent(halves.worst()),
                      Percent(halves.sigma()), Percent(kSigma)));
  }
  judge(!(question.rms_px <= kResidual), question.rms_px > kResidualWarned,
        fmt::format("the corner residual is {:.2f} px rms: expected {} px", question.rms_px,
                    kResidual));
  judge(!(question.sigma_focal <= kFocal), false,
        fmt::format("the focal length has a sigma of {}: expected {}; tilt the board more",
                    Percent(question.sigma_focal), Percent(kFocal)));
  for (const double coverage : question.coverage) {
    judge(!(coverage >= kCoverage), coverage < kCoverageWarned,
          fmt::format("corners cover only {:.0f} % of the image: expected {}, recommended {}",
                      100 * coverage, Percent(kCoverage), Percent(kCoverageWarned)));
  }
  judge(static_cast<double>(question.used) < kUsed * static_cast<double>(question.given), false,
        fmt::format("only {} of {} {} agree with each other", question.used, question.given,
                    question.things));
  return verdict;
}

bool AreSidesExchanged(const StereoRig& rig) {
  const Eigen::Vector3d right_L = rig.X_RL.inverse().translation();
  return right_L.x() < 0 && std::abs(right_L.x()) > std::abs(right_L.y());
}

StereoRig Exchanged(const StereoRig& rig) {
  StereoRig out = rig;
  std::swap(out.left, out.right);
  out.X_RL = rig.X_RL.inverse();
  return out;
}

}  // namespace palpate
