#include "slave/vision/calibration/pair_calibration.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include <opencv2/calib3d.hpp>

namespace palpate {
namespace {

constexpr std::size_t kFewest = 3;  // pairs
// A pair contradicts the others where it is this many times worse than their median, and by more
// pixels than an honest corner is ever off: against another pair's pose (which a single board only
// tells to a pixel or two), and in the joint refinement.
constexpr double kTimesMedian = 3;
constexpr double kRoughPixels = 3, kFinePixels = 0.6;

std::vector<Corners> SidesOf(const std::vector<PairView>& pairs, Corners PairView::*side) {
  std::vector<Corners> views;
  views.reserve(pairs.size());
  for (const PairView& pair : pairs) views.push_back(pair.*side);
  return views;
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<PairView> Chosen(const std::vector<PairView>& pairs,
                             const std::vector<std::size_t>& which) {
  std::vector<PairView> chosen;
  for (const std::size_t i : which) chosen.push_back(pairs[i]);
  return chosen;
}

// Rms [px] of a board's corners in the right picture, where the left one puts it.
double MissIn(const Lens& lens, const Eigen::Isometry3d& X_RB,
              const std::vector<cv::Point3f>& board, const Corners& seen) {
  double sum = 0;
  for (std::size_t i = 0; i < board.size(); ++i) {
    const auto at = Project(lens, X_RB * Eigen::Vector3d(board[i].x, board[i].y, board[i].z));
    if (!at) return HUGE_VAL;
    sum += (*at - Eigen::Vector2d(seen[i].x, seen[i].y)).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(board.size()));
}

// Every pair's miss under the relative pose that the larger half of the pairs agrees on best: each
// pair proposes one.
std::vector<double> MissesOfTheAgreed(const Board& board, const std::vector<PairView>& pairs,
                                      const LensCalibration& left, const LensCalibration& right) {
  const std::vector<cv::Point3f> points = BoardPoints(board);
  std::vector<double> best;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Isometry3d X_RL = right.X_CB[i] * left.X_CB[i].inverse();
    std::vector<double> misses;
    for (std::size_t j = 0; j < pairs.size(); ++j) {
      misses.push_back(MissIn(right.lens, X_RL * left.X_CB[j], points, pairs[j].right));
    }
    if (best.empty() || Median(misses) < Median(best)) best = misses;
  }
  return best;
}

double LimitOf(const std::vector<double>& residuals, double pixels) {
  return std::max(kTimesMedian * Median(residuals), pixels);
}

// Takes what is above the limit out of `used`.
void DropRough(const Board& board, const std::vector<PairView>& pairs, const PairSizes& sizes,
               PairCalibration* out) {
  const auto left = CalibrateLens(board, SidesOf(pairs, &PairView::left), sizes.left);
  const auto right = CalibrateLens(board, SidesOf(pairs, &PairView::right), sizes.right);
  const std::vector<double> misses = MissesOfTheAgreed(board, pairs, left, right);
  const double limit = LimitOf(misses, kRoughPixels);
  out->used.clear();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (misses[i] <= limit) {
      out->used.push_back(i);
    } else {
      out->dropped.push_back({i, misses[i]});
    }
  }
}

// Leaves the worst pair out if it contradicts the rest; whether it did.
bool DropWorst(PairCalibration* out) {
  std::vector<double> residuals;
  for (std::size_t i = 0; i < out->used.size(); ++i) {
    residuals.push_back(std::hypot(out->fit.left_px[i], out->fit.right_px[i]) / std::sqrt(2.0));
  }
  const auto worst = std::max_element(residuals.begin(), residuals.end());
  if (*worst <= LimitOf(residuals, kFinePixels)) return false;
  const auto at = worst - residuals.begin();
  out->dropped.push_back({out->used[static_cast<std::size_t>(at)], *worst});
  out->used.erase(out->used.begin() + at);
  return true;
}

Eigen::Isometry3d PoseOfBoard(const std::vector<cv::Point3f>& board, const Corners& seen,
                              const cv::Mat& K, const cv::Mat& D) {
  cv::Mat rotation, translation;
  cv::solvePnP(board, seen, K, D, rotation, translation);
  return PoseOf(rotation, translation);
}

void RequireEnough(const PairCalibration& calibration) {
  if (calibration.used.size() >= kFewest) return;
  throw std::runtime_error(
      "no three pairs agree on how the cameras stand to each other: accepted is a rigid pair and a "
      "board that does not move between the two shots");
}

}  // namespace

PairFit FitPair(const Board& board, const std::vector<PairView>& pairs, const PairSizes& sizes) {
  const std::vector<Corners> lefts = SidesOf(pairs, &PairView::left);
  const std::vector<Corners> rights = SidesOf(pairs, &PairView::right);
  const LensCalibration left = CalibrateLens(board, lefts, sizes.left);
  const LensCalibration right = CalibrateLens(board, rights, sizes.right);
  const std::vector<std::vector<cv::Point3f>> boards(pairs.size(), BoardPoints(board));
  const cv::TermCriteria settled(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-9);
  cv::Mat K_L(CameraMatrixOf(left.lens)), K_R(CameraMatrixOf(right.lens));
  cv::Mat D_L = DistortionOf(left.lens), D_R = DistortionOf(right.lens);
  cv::Mat R, T, E, F, per_view;
  PairFit out;
  try {
    out.rig.rms_px = cv::stereoCalibrate(boards, lefts, rights, K_L, D_L, K_R, D_R,
                                         {sizes.left[0], sizes.left[1]}, R, T, E, F, per_view,
                                         cv::CALIB_USE_INTRINSIC_GUESS | cv::CALIB_FIX_K3, settled);
    out.rig.left = LensOf(K_L, D_L, sizes.left);
    out.rig.right = LensOf(K_R, D_R, sizes.right);
    out.rig.X_RL = PoseOf(R, T);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      out.X_LB.push_back(PoseOfBoard(boards[i], lefts[i], K_L, D_L));
      out.left_px.push_back(per_view.at<double>(static_cast<int>(i), 0));
      out.right_px.push_back(per_view.at<double>(static_cast<int>(i), 1));
    }
  } catch (const cv::Exception&) {
    throw std::runtime_error("the pictures define no pair of cameras");
  }
  out.left_rms_px = left.rms_px;
  out.right_rms_px = right.rms_px;
  out.sigma_focal = std::max(left.sigma_focal, right.sigma_focal);
  return out;
}

PairCalibration CalibratePair(const Board& board, const std::vector<PairView>& pairs,
                              const PairSizes& sizes) {
  if (pairs.size() < kFewest) {
    throw std::runtime_error(std::to_string(pairs.size()) +
                             " pairs show the board: accepted is 3 or more");
  }
  PairCalibration out;
  DropRough(board, pairs, sizes, &out);
  do {
    RequireEnough(out);
    out.fit = FitPair(board, Chosen(pairs, out.used), sizes);
  } while (DropWorst(&out));
  return out;
}

}  // namespace palpate
