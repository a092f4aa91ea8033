#include "slave/vision/calibration/calibration.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>
#include <ranges>
#include <set>
#include <span>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "slave/statistics/robust.h"

namespace palpate {
namespace {

constexpr std::size_t kMinViews = 3, kMinToTrust = 4;

// OpenCV iterates until the norm of all parameters converges, including focal lengths of hundreds
// of pixels. With the square as unit, positions have a comparable weight, and the result does not
// depend on the unit.
std::vector<std::vector<cv::Point3f>> UnitBoards(Board board, std::size_t count) {
  board.square = 1;
  return {count, BoardPoints(board)};
}
const cv::TermCriteria kSettled{cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-9};

std::vector<Corners> SideOf(const std::vector<BoardView>& views, Corners BoardView::*side) {
  std::vector<Corners> corners;
  for (const BoardView& view : views) corners.push_back(view.*side);
  return corners;
}

// Throws std::runtime_error if the parameters are not those of a lens.
Lens LensOf(const cv::Mat& camera_matrix, const cv::Mat& distortion,
            const std::array<int, 2>& size) {
  Lens lens;
  lens.fx = camera_matrix.at<double>(0, 0), lens.cx = camera_matrix.at<double>(0, 2);
  lens.fy = camera_matrix.at<double>(1, 1), lens.cy = camera_matrix.at<double>(1, 2);
  std::copy_n(distortion.ptr<double>(), lens.distortion.size(), lens.distortion.begin());
  lens.size = size;
  if (!cv::checkRange(camera_matrix) || !cv::checkRange(distortion) || !(lens.fx > 0) ||
      !(lens.fy > 0)) {
    throw std::runtime_error("the images do not determine a lens: no focal length fits");
  }
  return lens;
}

struct LensFit {
  Lens lens;
  double rms_px = 0, sigma_focal = 0;
  std::vector<double> view_rms_px;
  std::vector<Eigen::Isometry3d> X_CB;
};

LensFit FitLens(const Board& board, const std::vector<Corners>& views,
                const std::array<int, 2>& size) {
  cv::Mat K, D, sigmas, sigmas_of_poses;
  std::vector<cv::Mat> rotations, translations;
  LensFit out;
  try {
    out.rms_px = cv::calibrateCamera(UnitBoards(board, views.size()), views, {size[0], size[1]}, K,
                                     D, rotations, translations, sigmas, sigmas_of_poses,
                                     out.view_rms_px, cv::CALIB_FIX_K3, kSettled);
  } catch (const cv::Exception&) {
    throw std::runtime_error(
        "the images do not determine a lens: the poses of the board are too similar");
  }
  out.lens = LensOf(K, D, size);
  out.sigma_focal =
      std::max(sigmas.at<double>(0) / out.lens.fx, sigmas.at<double>(1) / out.lens.fy);
  for (std::size_t i = 0; i < views.size(); ++i) {
    out.X_CB.push_back(PoseOf(rotations[i], board.square * translations[i]));
  }
  return out;
}

// Refines both lenses and the pose jointly, from lenses near the result. `view_rms_px`: one row per
// view with left and right values.
StereoRig FitRig(const Board& board, const std::vector<BoardView>& views, const StereoRig& start,
                 cv::Mat* view_rms_px) {
  cv::Mat K_L(CameraMatrixOf(start.left)), K_R(CameraMatrixOf(start.right));
  cv::Mat D_L = DistortionOf(start.left), D_R = DistortionOf(start.right);
  cv::Mat R, T, E, F;
  StereoRig rig;
  try {
    rig.rms_px =
        cv::stereoCalibrate(UnitBoards(board, views.size()), SideOf(views, &BoardView::left),
                            SideOf(views, &BoardView::right), K_L, D_L, K_R, D_R,
                            {start.left.size[0], start.left.size[1]}, R, T, E, F, *view_rms_px,
                            cv::CALIB_USE_INTRINSIC_GUESS | cv::CALIB_FIX_K3, kSettled);
  } catch (const cv::Exception&) {
    throw std::runtime_error("the images do not determine a stereo pair");
  }
  rig.left = LensOf(K_L, D_L, start.left.size);
  rig.right = LensOf(K_R, D_R, start.right.size);
  rig.X_RL = PoseOf(R, board.square * T);
  return rig;
}

// Chooses the order of the right corners for which the rotation between the cameras agrees best
// with that of one pair. Each order corresponds to a rotation of the board about its normal.
void AlignOrders(const LensFit& left, const LensFit& right, Calibration* c) {
  const std::array<double, 4> turns{0, M_PI, M_PI / 2, -M_PI / 2};  // in the order of OrdersOf
  const std::size_t count = OrdersOf(c->views.front().right, c->board).size();
  const auto rotation = [&](std::size_t view, std::size_t order) {
    return Eigen::Quaterniond(right.X_CB[view].linear() *
                              Eigen::AngleAxisd(turns[order], Eigen::Vector3d::UnitZ()) *
                              left.X_CB[view].linear().transpose());
  };
  double least = HUGE_VAL;
  std::vector<std::size_t> best;
  for (std::size_t k = 0; k < c->views.size() * count; ++k) {
    const Eigen::Quaterniond proposed = rotation(k / count, k % count);
    std::vector<std::size_t> orders;
    double sum = 0;
    for (std::size_t i = 0; i < c->views.size(); ++i) {
      const auto angle = [&](std::size_t o) { return rotation(i, o).angularDistance(proposed); };
      orders.push_back(std::ranges::min(std::views::iota(std::size_t{0}, count), {}, angle));
      sum += angle(orders.back());
    }
    if (sum < least) least = sum, best = orders;
  }
  for (std::size_t i = 0; i < c->views.size(); ++i) {
    c->views[i].right = OrdersOf(c->views[i].right, c->board)[best[i]];
  }
}

// Fits everything to the views of `c`.
void Fit(const ImageSizes& sizes, Calibration* c) {
  const LensFit left = FitLens(c->board, SideOf(c->views, &BoardView::left), sizes.left);
  c->rig = {.left = left.lens, .rms_px = left.rms_px};
  c->sigma_focal = left.sigma_focal;
  c->X_LB = left.X_CB;
  c->rms_px.clear();
  c->own_px.clear();
  if (!c->is_pair) {
    for (const double rms_px : left.view_rms_px) c->rms_px.push_back({rms_px, 0});
    return;
  }
  const LensFit right = FitLens(c->board, SideOf(c->views, &BoardView::right), sizes.right);
  AlignOrders(left, right, c);
  c->rig.right = right.lens;
  cv::Mat view_rms_px;
  c->rig = FitRig(c->board, c->views, c->rig, &view_rms_px);
  c->sigma_focal = std::max(left.sigma_focal, right.sigma_focal);
  for (std::size_t i = 0; i < c->views.size(); ++i) {
    const double* row = view_rms_px.ptr<double>(static_cast<int>(i));
    c->rms_px.push_back({row[0], row[1]});
    c->own_px.push_back(std::hypot(left.view_rms_px[i], right.view_rms_px[i]) / std::sqrt(2.0));
  }
}

// Returns the view that contradicts the others most; nullopt: none. Corner noise and lens errors
// have the same effect with a common board pose as with separate poses for left and right; motion
// between the exposures does not.
std::optional<std::size_t> Outlier(const Calibration& c) {
  constexpr double kTimesMedian = 3, kCornerPixels = 0.6, kMotionPixels = 0.25;
  std::vector<double> misses, motions;  // [px]
  for (std::size_t i = 0; i < c.views.size(); ++i) {
    const auto& [left, right] = c.rms_px[i];
    misses.push_back(std::max(left, right));
    if (!c.is_pair) continue;
    const double excess = (left * left + right * right) / 2 - c.own_px[i] * c.own_px[i];
    motions.push_back(std::sqrt(std::max(0.0, excess)));
  }
  if (c.is_pair) {
    const auto i = static_cast<std::size_t>(std::ranges::max_element(motions) - motions.begin());
    if (motions[i] > std::max(kMotionPixels, c.own_px[i])) return i;
  }
  const auto i = static_cast<std::size_t>(std::ranges::max_element(misses) - misses.begin());
  const double limit = std::max(kTimesMedian * MedianOf(std::vector(misses)), kCornerPixels);
  return misses[i] > limit ? std::optional(i) : std::nullopt;
}

void Drop(std::size_t k, Calibration* c) {
  const auto& [left, right] = c->rms_px[k];
  c->dropped.push_back({c->used[k], std::max(left, right)});
  c->used.erase(c->used.begin() + static_cast<std::ptrdiff_t>(k));
  c->views.erase(c->views.begin() + static_cast<std::ptrdiff_t>(k));
}

// The quantity whose standard deviation is computed.
double QuantityOf(const StereoRig& rig) {
  return rig.baseline() > 0 ? rig.baseline() : std::sqrt(rig.left.fx * rig.left.fy);
}

// Returns the group of each view: views whose corners are near those of an earlier view, within 1 %
// of the image's width (rms).
std::vector<std::size_t> GroupsOf(const Calibration& c) {
  constexpr double kAlike = 0.01;
  const auto count = static_cast<double>(c.views.front().left.size());
  std::vector<std::size_t> firsts, groups;
  for (const BoardView& view : c.views) {
    const auto like = std::ranges::find_if(firsts, [&](std::size_t first) {
      return cv::norm(view.left, c.views[first].left) <
             kAlike * c.rig.left.size[0] * std::sqrt(count);
    });
    groups.push_back(static_cast<std::size_t>(like - firsts.begin()));
    if (like == firsts.end()) firsts.push_back(groups.size() - 1);
  }
  return groups;
}

// Calibrates with the views of the chosen groups only.
double EstimateFrom(const Calibration& c, const std::vector<std::size_t>& groups,
                    std::span<const std::size_t> chosen) {
  std::vector<BoardView> views;
  for (const std::size_t group : chosen) {
    for (std::size_t i = 0; i < groups.size(); ++i) {
      if (groups[i] == group) views.push_back(c.views[i]);
    }
  }
  StereoRig rig;
  cv::Mat view_rms_px;
  if (c.is_pair) return QuantityOf(FitRig(c.board, views, c.rig, &view_rms_px));
  rig.left = FitLens(c.board, SideOf(views, &BoardView::left), c.rig.left.size).lens;
  return QuantityOf(rig);
}

// The variance of a half is twice that of all views, and the variance of the difference of two
// halves is four times it.
void SetSigma(Calibration* c) {
  constexpr int kHalves = 21;  // odd and even views, then random halves
  const std::vector<std::size_t> groups = GroupsOf(*c);
  c->distinct = 1 + std::ranges::max(groups);
  c->sigma = HUGE_VAL;
  if (c->distinct < kMinToTrust) return;
  std::vector<std::size_t> all(c->distinct);
  std::iota(all.begin(), all.end(), std::size_t{0});
  double sum = 0;
  std::mt19937 random(20);
  for (int k = 0; k < kHalves; ++k) {
    std::vector<std::size_t> order = all;
    std::size_t half = c->distinct / 2;
    if (k == 0) {
      const auto odd =
          std::ranges::stable_partition(order, [](std::size_t i) { return i % 2 == 0; });
      half = c->distinct - odd.size();
    }
    // Fisher-Yates shuffle, because std::shuffle is not reproducible across libraries.
    for (std::size_t i = order.size() - 1; k > 0 && i > 0; --i) {
      std::swap(order[i], order[random() % (i + 1)]);
    }
    double difference = 1;  // largest value, used if a half does not determine the quantity
    try {
      const std::span<const std::size_t> views = order;
      difference = (EstimateFrom(*c, groups, views.first(half)) -
                    EstimateFrom(*c, groups, views.subspan(half))) /
                   QuantityOf(c->rig);
    } catch (const std::runtime_error&) {
    }
    sum += difference * difference;
  }
  c->sigma = 0.5 * std::sqrt(sum / kHalves);
}

double CoverageOf(const std::vector<Corners>& views, const std::array<int, 2>& size) {
  constexpr int kColumns = 8, kRows = 6;
  std::set<std::pair<int, int>> covered;
  for (const Corners& view : views) {
    for (const cv::Point2f& p : view) {
      covered.emplace(static_cast<int>(p.x * kColumns / static_cast<float>(size[0])),
                      static_cast<int>(p.y * kRows / static_cast<float>(size[1])));
    }
  }
  return static_cast<double>(covered.size()) / (kColumns * kRows);
}

// Limits, and values from which on there is a warning.
constexpr double kSigma = 0.01, kSigmaWarned = 0.005;  // relative sigma of baseline or focal length
constexpr double kResidual = 1.0, kResidualWarned = 0.5;   // [px]
constexpr double kCoverage = 0.15, kCoverageWarned = 0.4;  // covered part of the image
constexpr double kFocal = 0.02;                            // relative sigma of the focal length
constexpr double kUsedViews = 0.5;                         // of the views that show the board

void SetVerdict(Calibration* c) {
  const auto judge = [&](bool is_refused, bool is_weak, const std::string& words) {
    if (is_refused) {
      c->reasons.push_back(words);
    } else if (is_weak) {
      c->warnings.push_back(words);
    }
  };
  const char* things = c->is_pair ? "pairs" : "images";
  if (c->distinct < kMinToTrust) {
    c->reasons.push_back(
        fmt::format("{} different {} are too few: expected {} or more, each with another position "
                    "of the board",
                    c->distinct, things, kMinToTrust));
  } else {
    judge(!(c->sigma <= kSigma), c->sigma > kSigmaWarned,
          fmt::format("halves of the images differ in the {}: one sigma from all of them is "
                      "{:.2g} %, expected at most {:g} %",
                      c->is_pair ? "baseline" : "focal length", 100 * c->sigma, 100 * kSigma));
  }
  judge(!(c->rig.rms_px <= kResidual), c->rig.rms_px > kResidualWarned,
        fmt::format("the corner residual is {:.2f} px rms: expected {} px", c->rig.rms_px,
                    kResidual));
  judge(!(c->sigma_focal <= kFocal), false,
        fmt::format("the focal length has a sigma of {:.2g} %: expected {:g} %; tilt the board "
                    "more",
                    100 * c->sigma_focal, 100 * kFocal));
  for (const double coverage : c->coverage) {
    judge(!(coverage >= kCoverage), coverage < kCoverageWarned,
          fmt::format("corners cover only {:.0f} % of the image: expected {:g} %, recommended {:g} "
                      "%",
                      100 * coverage, 100 * kCoverage, 100 * kCoverageWarned));
  }
  const std::size_t used = c->used.size(), given = used + c->dropped.size();
  judge(static_cast<double>(used) < kUsedViews * static_cast<double>(given), false,
        fmt::format("only {} of {} {} agree with each other", used, given, things));
  constexpr double kMinBaseline = 1e-3;  // of the board's distance
  const double distance = c->X_LB.front().translation().norm();
  judge(c->is_pair && !(c->rig.baseline() > kMinBaseline * distance), false,
        "both cameras have the same position: expected images of two cameras side by side, not the "
        "same images twice");
}

}  // namespace

cv::Matx33d CameraMatrixOf(const Lens& lens) {
  return {lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1};
}

cv::Mat DistortionOf(const Lens& lens) {
  return cv::Mat(1, 5, CV_64F, const_cast<double*>(lens.distortion.data())).clone();
}

Eigen::Isometry3d PoseOf(const cv::Mat& rotation, const cv::Mat& translation) {
  cv::Mat R = rotation;
  if (rotation.total() == 3) cv::Rodrigues(rotation, R);
  Eigen::Matrix3d linear;
  Eigen::Vector3d shift;
  cv::cv2eigen(R, linear);
  cv::cv2eigen(translation, shift);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = linear;
  X.translation() = shift;
  if (!X.matrix().allFinite()) throw std::runtime_error("the images do not determine a pose");
  return X;
}

Calibration Calibrate(const Board& board, const std::vector<BoardView>& views,
                      const ImageSizes& sizes) {
  if (views.size() < kMinViews) {
    throw std::runtime_error(fmt::format("{} images or pairs show the board: expected {} or more",
                                         views.size(), kMinViews));
  }
  Calibration out;
  out.board = board;
  out.is_pair = !views.front().right.empty();
  out.views = views;
  for (std::size_t i = 0; i < views.size(); ++i) out.used.push_back(i);
  Fit(sizes, &out);
  for (auto i = Outlier(out); i && out.views.size() > kMinViews; i = Outlier(out)) {
    Drop(*i, &out);
    Fit(sizes, &out);
  }
  out.coverage.push_back(CoverageOf(SideOf(out.views, &BoardView::left), sizes.left));
  if (out.is_pair) {
    out.coverage.push_back(CoverageOf(SideOf(out.views, &BoardView::right), sizes.right));
  }
  SetSigma(&out);
  SetVerdict(&out);
  return out;
}

bool AreSidesExchanged(const StereoRig& rig) {
  const Eigen::Vector3d right_L = rig.X_RL.inverse().translation();
  return right_L.x() < 0 && std::abs(right_L.x()) > std::abs(right_L.y());
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
    out.back().value.resize(m.rows, m.cols);  // OpenCV does not do this for row-major matrices
    cv::cv2eigen(m, out.back().value);
  }
  return out;
}

}  // namespace palpate
