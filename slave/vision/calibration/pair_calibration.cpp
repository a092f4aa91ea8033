#include "slave/vision/calibration/pair_calibration.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "slave/statistics/robust.h"

namespace palpate {
namespace {

constexpr std::size_t kFewestPairs = 3;  // pairs
// What an honest pair stays below: against another pair's pose, which a single board only tells to
// a pixel or two; and by its rift.
constexpr double kRoughPixels = 3, kRiftPixels = 0.25;
constexpr double kTimesMedian = 3;
// Share of the image's width: beyond it there is no agreement. Real pairs stay below 0.3 %, images
// of different instants miss each other by 7 % and more.
constexpr double kNoAgreement = 0.02;

std::vector<Corners> SidesOf(const std::vector<PairView>& pairs, Corners PairView::*side) {
  std::vector<Corners> views;
  views.reserve(pairs.size());
  for (const PairView& pair : pairs) views.push_back(pair.*side);
  return views;
}

// Rms [px] of a board's corners where X_RB puts them, against where they are seen.
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

struct BoardPose {
  Eigen::Isometry3d X_CB = Eigen::Isometry3d::Identity();
  double rms_px = 0;
};
// Pose of a board in the frame of one camera with a known lens.
BoardPose PoseOfBoard(const std::vector<cv::Point3f>& board, const Corners& seen,
                      const Lens& lens) {
  cv::Mat rotation, translation;
  cv::solvePnP(board, seen, CameraMatrixOf(lens), DistortionOf(lens), rotation, translation);
  const Eigen::Isometry3d X_CB = PoseOf(rotation, translation);
  return {X_CB, MissIn(lens, X_CB, board, seen)};
}

// Misses of all pairs under one relative pose of the cameras.
struct Agreement {
  std::vector<double> misses;   // [px]
  std::vector<PairView> views;  // right corners in the order that misses least
};

// The relative pose with the least median of the misses (least median of squares): each pair
// proposes one for each order of its right corners.
Agreement FindAgreement(const Board& board, const std::vector<PairView>& pairs,
                        const PairSizes& sizes) {
  const std::vector<cv::Point3f> points = BoardPoints(board);
  const LensCalibration left = CalibrateLens(board, SidesOf(pairs, &PairView::left), sizes.left);
  const LensCalibration right = CalibrateLens(board, SidesOf(pairs, &PairView::right), sizes.right);
  std::vector<std::vector<Corners>> orders;
  for (const PairView& pair : pairs) orders.push_back(OrdersOf(pair.right, board));
  const auto agreement_for = [&](const Eigen::Isometry3d& X_RL) {
    Agreement out;
    for (std::size_t j = 0; j < pairs.size(); ++j) {
      double least = HUGE_VAL;
      const Corners* best = &orders[j].front();
      for (const Corners& order : orders[j]) {
        const double miss = MissIn(right.lens, X_RL * left.X_CB[j], points, order);
        if (miss < least) least = miss, best = &order;
      }
      out.misses.push_back(least);
      out.views.push_back({pairs[j].left, *best});
    }
    return out;
  };
  Agreement best;
  double least = HUGE_VAL;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    for (const Corners& order : orders[i]) {
      const Eigen::Isometry3d X_RB = PoseOfBoard(points, order, right.lens).X_CB;
      Agreement found = agreement_for(X_RB * left.X_CB[i].inverse());
      const double median = MedianOf(std::vector(found.misses));
      if (best.views.empty() || median < least) least = median, best = std::move(found);
    }
  }
  return best;
}

// Pairs that agree roughly with the others.
PairCalibration TakeRough(const Board& board, const std::vector<PairView>& pairs,
                          const PairSizes& sizes) {
  const Agreement agreement = FindAgreement(board, pairs, sizes);
  const double limit =
      std::min(std::max(kTimesMedian * MedianOf(std::vector(agreement.misses)), kRoughPixels),
               kNoAgreement * sizes.right[0]);
  PairCalibration out;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (agreement.misses[i] <= limit) {
      out.used.push_back(i);
      out.views.push_back(agreement.views[i]);
    } else {
      out.dropped.push_back({i, agreement.misses[i]});
    }
  }
  return out;
}

struct Refined {
  StereoRig rig;
  cv::Mat per_view;  // pairs x 2 [px]
};

Refined Refine(const Board& board, const std::vector<PairView>& pairs, const StereoRig& start) {
  const std::vector<std::vector<cv::Point3f>> boards(pairs.size(), BoardPoints(UnitBoard(board)));
  cv::Mat K_L(CameraMatrixOf(start.left)), K_R(CameraMatrixOf(start.right));
  cv::Mat D_L = DistortionOf(start.left), D_R = DistortionOf(start.right);
  cv::Mat R, T, E, F;
  Refined out;
  try {
    out.rig.rms_px = cv::stereoCalibrate(
        boards, SidesOf(pairs, &PairView::left), SidesOf(pairs, &PairView::right), K_L, D_L, K_R,
        D_R, {start.left.size[0], start.left.size[1]}, R, T, E, F, out.per_view,
        cv::CALIB_USE_INTRINSIC_GUESS | cv::CALIB_FIX_K3, Settled());
  } catch (const cv::Exception&) {
    throw std::runtime_error("the images do not determine a stereo pair");
  }
  out.rig.left = LensOf(K_L, D_L, start.left.size);
  out.rig.right = LensOf(K_R, D_R, start.right.size);
  out.rig.X_RL = PoseOf(R, board.square * T);
  return out;
}

PairCalibration Without(PairCalibration calibration, std::size_t k) {
  const PairFit& fit = calibration.fit;
  const double miss = std::hypot(fit.left_px[k], fit.right_px[k]) / std::sqrt(2.0);
  calibration.dropped.push_back({calibration.used[k], miss});
  calibration.used.erase(calibration.used.begin() + static_cast<std::ptrdiff_t>(k));
  calibration.views.erase(calibration.views.begin() + static_cast<std::ptrdiff_t>(k));
  return calibration;
}

void RequireEnough(const PairCalibration& calibration) {
  if (calibration.used.size() >= kFewestPairs) return;
  throw std::runtime_error(
      "no three pairs agree on the relative pose of the cameras: expected a rigid pair and a "
      "board that does not move between the two exposures");
}

// A baseline of nothing cannot be checked by its halves, and sees no depth.
void RequireApart(const PairFit& fit) {
  constexpr double kLeast = 1e-3;  // of the board's distance
  double distance = 0;
  for (const Eigen::Isometry3d& X_LB : fit.X_LB) {
    distance = std::max(distance, X_LB.translation().norm());
  }
  if (fit.rig.baseline() > kLeast * distance) return;
  throw std::runtime_error(
      "both cameras have the same position: expected images of two cameras side by side, not "
      "the same images twice");
}

// A pair that is torn pulls the common pose towards itself and tears at the others: it is compared
// to what they are like without it.
std::optional<PairCalibration> WithoutTorn(const Board& board, const PairSizes& sizes,
                                           const PairCalibration& calibration) {
  const std::vector<double>& rifts = calibration.fit.rift_px;
  const auto worst = std::max_element(rifts.begin(), rifts.end());
  if (*worst <= kRiftPixels || rifts.size() <= kFewestPairs) return std::nullopt;
  PairCalibration rest = Without(calibration, static_cast<std::size_t>(worst - rifts.begin()));
  rest.fit = FitPair(board, rest.views, sizes);
  if (*worst <= kTimesMedian * MedianOf(std::vector(rest.fit.rift_px))) return std::nullopt;
  return rest;
}

std::optional<PairCalibration> WithoutMisseen(const Board& board, const PairSizes& sizes,
                                              const PairCalibration& calibration) {
  std::vector<double> corners;
  for (std::size_t k = 0; k < calibration.used.size(); ++k) {
    corners.push_back(std::max(calibration.fit.left_px[k], calibration.fit.right_px[k]));
  }
  const auto worst = Outlier(corners, kCornerPixels);
  if (!worst || corners.size() <= kFewestPairs) return std::nullopt;
  PairCalibration rest = Without(calibration, *worst);
  rest.fit = FitPair(board, rest.views, sizes);
  return rest;
}

}  // namespace

PairFit FitPair(const Board& board, const std::vector<PairView>& pairs, const PairSizes& sizes) {
  const LensCalibration left = CalibrateLens(board, SidesOf(pairs, &PairView::left), sizes.left);
  const LensCalibration right = CalibrateLens(board, SidesOf(pairs, &PairView::right), sizes.right);
  StereoRig start;
  start.left = left.lens, start.right = right.lens;
  const Refined refined = Refine(board, pairs, start);
  PairFit out;
  out.rig = refined.rig;
  const std::vector<cv::Point3f> points = BoardPoints(board);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const BoardPose in_left = PoseOfBoard(points, pairs[i].left, out.rig.left);
    const BoardPose in_right = PoseOfBoard(points, pairs[i].right, out.rig.right);
    out.left_px.push_back(refined.per_view.at<double>(static_cast<int>(i), 0));
    out.right_px.push_back(refined.per_view.at<double>(static_cast<int>(i), 1));
    const double joint = std::hypot(out.left_px[i], out.right_px[i]);
    const double own = std::hypot(in_left.rms_px, in_right.rms_px);
    out.rift_px.push_back(std::sqrt(std::max(0.0, 0.5 * (joint * joint - own * own))));
    out.X_LB.push_back(in_left.X_CB);
  }
  out.sigma_focal = std::max(left.sigma_focal, right.sigma_focal);
  return out;
}

StereoRig RefinePair(const Board& board, const std::vector<PairView>& pairs,
                     const StereoRig& start) {
  return Refine(board, pairs, start).rig;
}

std::vector<NamedMatrix> Rectification(const StereoRig& rig) {
  cv::Matx33d R;
  cv::Vec3d T;
  cv::eigen2cv(Eigen::Matrix3d(rig.X_RL.linear()), R);
  cv::eigen2cv(Eigen::Vector3d(rig.X_RL.translation()), T);
  cv::Mat R1, R2, P1, P2, Q;
  cv::stereoRectify(CameraMatrixOf(rig.left), DistortionOf(rig.left), CameraMatrixOf(rig.right),
                    DistortionOf(rig.right), cv::Size(rig.left.size[0], rig.left.size[1]), R, T, R1,
                    R2, P1, P2, Q, cv::CALIB_ZERO_DISPARITY, 0);
  std::vector<NamedMatrix> out;
  for (const auto& [name, m] :
       {std::pair{"R1", R1}, {"R2", R2}, {"P1", P1}, {"P2", P2}, {"Q", Q}}) {
    out.push_back({name, {}});
    out.back().value.resize(m.rows, m.cols);  // where it is row-major OpenCV leaves this to us
    cv::cv2eigen(m, out.back().value);
  }
  return out;
}

PairCalibration CalibratePair(const Board& board, const std::vector<PairView>& pairs,
                              const PairSizes& sizes) {
  if (pairs.size() < kFewestPairs) {
    throw std::runtime_error(std::to_string(pairs.size()) +
                             " pairs show the board: expected 3 or more");
  }
  PairCalibration out = TakeRough(board, pairs, sizes);
  RequireEnough(out);
  out.fit = FitPair(board, out.views, sizes);
  for (;;) {
    auto rest = WithoutTorn(board, sizes, out);
    if (!rest) rest = WithoutMisseen(board, sizes, out);
    if (!rest) break;
    out = *std::move(rest);
  }
  RequireApart(out.fit);
  return out;
}

}  // namespace palpate
