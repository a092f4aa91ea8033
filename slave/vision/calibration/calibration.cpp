#include "slave/vision/calibration/calibration.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "slave/statistics/robust.h"

namespace palpate {
namespace {

constexpr std::size_t kMinViews = 3, kMinToTrust = 4;
const cv::TermCriteria kSettled{cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-9};

// OpenCV iterates until the norm of all parameters converges, including focal lengths of hundreds
// of pixels. With the square as unit, positions have a comparable weight, and the result does not
// depend on the unit.
std::vector<std::vector<cv::Point3f>> UnitBoards(const Board& board, std::size_t count) {
  std::vector<cv::Point3f> points;
  for (int j = 0; j < board.rows; ++j) {
    for (int i = 0; i < board.columns; ++i) {
      points.emplace_back(static_cast<float>(i), static_cast<float>(j), 0.0F);
    }
  }
  return {count, points};
}

std::vector<Corners> SideOf(const std::vector<BoardView>& views, Corners BoardView::*side) {
  std::vector<Corners> corners;
  for (const BoardView& view : views) corners.push_back(view.*side);
  return corners;
}

struct LensFit {
  cv::Mat K, D;  // as OpenCV has them
  Lens lens;
  double rms_px = 0;
  std::vector<double> view_rms_px;
};

// Throws std::runtime_error if the parameters are not those of a lens.
Lens LensOf(const cv::Mat& K, const cv::Mat& D, const std::array<int, 2>& size) {
  Lens lens;
  lens.fx = K.at<double>(0, 0), lens.cx = K.at<double>(0, 2);
  lens.fy = K.at<double>(1, 1), lens.cy = K.at<double>(1, 2);
  std::copy_n(D.ptr<double>(), lens.distortion.size(), lens.distortion.begin());
  lens.size = size;
  if (!cv::checkRange(K) || !cv::checkRange(D) || !(lens.fx > 0) || !(lens.fy > 0)) {
    throw std::runtime_error("the images do not determine a lens: no focal length fits");
  }
  return lens;
}

LensFit FitLens(const Board& board, const std::vector<Corners>& views,
                const std::array<int, 2>& size) {
  LensFit out;
  std::vector<cv::Mat> rotations, translations;
  try {
    out.rms_px = cv::calibrateCamera(UnitBoards(board, views.size()), views, {size[0], size[1]},
                                     out.K, out.D, rotations, translations, cv::noArray(),
                                     cv::noArray(), out.view_rms_px, cv::CALIB_FIX_K3, kSettled);
  } catch (const cv::Exception&) {
    throw std::runtime_error(
        "the images do not determine a lens: the poses of the board are too similar");
  }
  out.lens = LensOf(out.K, out.D, size);
  return out;
}

struct Fit {
  StereoRig rig;
  std::vector<std::array<double, 2>> rms_px;  // of the left and the right image
  std::vector<double> own_px;                 // of pairs, with a pose of the board for each camera
};

Fit FitRig(const Board& board, const std::vector<BoardView>& views, const ImageSizes& sizes) {
  LensFit left = FitLens(board, SideOf(views, &BoardView::left), sizes.left);
  Fit out;
  if (views.front().right.empty()) {
    out.rig = {.left = left.lens, .rms_px = left.rms_px};
    for (const double rms_px : left.view_rms_px) out.rms_px.push_back({rms_px, 0});
    return out;
  }
  LensFit right = FitLens(board, SideOf(views, &BoardView::right), sizes.right);
  cv::Mat R, T, E, F, rms_px;
  try {
    out.rig.rms_px =
        cv::stereoCalibrate(UnitBoards(board, views.size()), SideOf(views, &BoardView::left),
                            SideOf(views, &BoardView::right), left.K, left.D, right.K, right.D,
                            {sizes.left[0], sizes.left[1]}, R, T, E, F, rms_px,
                            cv::CALIB_USE_INTRINSIC_GUESS | cv::CALIB_FIX_K3, kSettled);
  } catch (const cv::Exception&) {
    throw std::runtime_error("the images do not determine a stereo pair");
  }
  out.rig.left = LensOf(left.K, left.D, sizes.left);
  out.rig.right = LensOf(right.K, right.D, sizes.right);
  Eigen::Matrix3d linear;
  Eigen::Vector3d shift;
  cv::cv2eigen(R, linear);
  cv::cv2eigen(T, shift);
  out.rig.X_RL = Eigen::Translation3d(board.square * shift) * Eigen::Isometry3d(linear);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double* row = rms_px.ptr<double>(static_cast<int>(i));
    out.rms_px.push_back({row[0], row[1]});
    out.own_px.push_back(std::hypot(left.view_rms_px[i], right.view_rms_px[i]) / std::sqrt(2.0));
  }
  return out;
}

// Returns the view that contradicts the others most; nullopt: none. Corner noise and lens errors
// have the same effect with a common board pose as with separate poses for left and right; motion
// between the exposures does not.
std::optional<std::size_t> Outlier(const Fit& fit) {
  constexpr double kTimesMedian = 3, kCornerPixels = 0.6, kMotionPixels = 0.25;
  std::vector<double> misses, excesses;  // [px]; excess: of pairs, over the limit of motion
  for (std::size_t i = 0; i < fit.rms_px.size(); ++i) {
    const auto& [left, right] = fit.rms_px[i];
    misses.push_back(std::max(left, right));
    if (fit.own_px.empty()) continue;
    const double own = fit.own_px[i];
    const double motion = std::sqrt(std::max(0.0, (left * left + right * right) / 2 - own * own));
    excesses.push_back(motion - std::max(kMotionPixels, own));
  }
  const auto moved = std::ranges::max_element(excesses);
  if (moved != excesses.end() && *moved > 0) {
    return static_cast<std::size_t>(moved - excesses.begin());
  }
  const auto worst = std::ranges::max_element(misses);
  const double limit = std::max(kTimesMedian * MedianOf(std::vector(misses)), kCornerPixels);
  if (*worst <= limit) return std::nullopt;
  return static_cast<std::size_t>(worst - misses.begin());
}

// Returns whether the corners are near those of one of `others`, within 1 % of the image's width
// (rms).
bool Repeats(const BoardView& view, const std::vector<BoardView>& others, int width) {
  const double limit = 0.01 * width * std::sqrt(static_cast<double>(view.left.size()));
  return std::ranges::any_of(
      others, [&](const BoardView& other) { return cv::norm(view.left, other.left) < limit; });
}

// The quantity whose standard deviation is computed.
double QuantityOf(const StereoRig& rig) {
  return rig.baseline() > 0 ? rig.baseline() : std::sqrt(rig.left.fx * rig.left.fy);
}

double SigmaOf(const Board& board, const std::vector<BoardView>& views, const ImageSizes& sizes) {
  if (views.size() < kMinToTrust) return HUGE_VAL;
  const auto count = static_cast<double>(views.size());
  std::vector<double> without;
  double mean = 0, square = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    std::vector<BoardView> others = views;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    try {
      without.push_back(QuantityOf(FitRig(board, others, sizes).rig));
    } catch (const std::runtime_error&) {
      return HUGE_VAL;
    }
    mean += without.back() / count;
  }
  for (const double quantity : without) square += (quantity - mean) * (quantity - mean);
  return std::sqrt((count - 1) / count * square) / mean;
}

// `contradicting`: number of views that were dropped as outliers.
void SetVerdict(const Board& board, std::size_t contradicting, Calibration* c) {
  constexpr double kSigma = 0.01;       // relative, of baseline or focal length
  constexpr double kResidual = 1;       // [px]
  constexpr double kUsedViews = 0.5;    // of the views that show the board
  constexpr double kMinBaseline = 0.1;  // in squares of the board
  const auto reject = [&](bool is_rejected, const std::string& words) {
    if (is_rejected) c->reasons.push_back(words);
  };
  const char* things = c->is_pair ? "pairs" : "images";
  const std::size_t used = c->used.size(), given = used + contradicting;
  reject(used < kMinToTrust,
         fmt::format("{} different {} are too few: expected {} or more, each with another position "
                     "of the board",
                     used, things, kMinToTrust));
  reject(
      used >= kMinToTrust && !(c->sigma <= kSigma),
      fmt::format("the {} has a sigma of {:.2g} %, from fits without one of the {} each: "
                  "expected at most {:g} %; tilt the board more",
                  c->is_pair ? "baseline" : "focal length", 100 * c->sigma, things, 100 * kSigma));
  reject(!(c->rig.rms_px <= kResidual),
         fmt::format("the corner residual is {:.2f} px rms: expected at most {} px", c->rig.rms_px,
                     kResidual));
  reject(static_cast<double>(used) < kUsedViews * static_cast<double>(given),
         fmt::format("only {} of {} {} agree with each other", used, given, things));
  const Eigen::Vector3d right_L = c->rig.X_RL.inverse().translation();
  const bool is_apart = right_L.norm() > kMinBaseline * board.square;
  reject(c->is_pair && !is_apart,
         "both cameras have the same position: expected images of two cameras side by side, not "
         "the same images twice");
  reject(c->is_pair && is_apart && right_L.x() < 0 && -right_L.x() > std::abs(right_L.y()),
         "left and right are exchanged: the camera given as the left one is to the right of the "
         "other, or both are upside down. Exchange --left and --right, and the images in the "
         "scene");
}

}  // namespace

Calibration Calibrate(const Board& board, const std::vector<BoardView>& views,
                      const ImageSizes& sizes) {
  if (views.size() < kMinViews) {
    throw std::runtime_error(fmt::format("{} images or pairs show the board: expected {} or more",
                                         views.size(), kMinViews));
  }
  Calibration out;
  out.is_pair = !views.front().right.empty();
  if (out.is_pair && (board.columns + board.rows) % 2 == 0) {
    throw std::runtime_error(
        "this board looks the same after half a turn: expected an odd and an even count of corners "
        "for a pair, for example 9x6");
  }
  std::vector<BoardView> used;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (used.size() >= kMinViews && Repeats(views[i], used, sizes.left[0])) {
      out.dropped.push_back({i, "the board is where another image shows it"});
    } else {
      used.push_back(views[i]);
      out.used.push_back(i);
    }
  }
  const std::size_t different = used.size();
  Fit fit = FitRig(board, used, sizes);
  for (auto i = Outlier(fit); i && used.size() > kMinViews; i = Outlier(fit)) {
    const double miss_px = std::max(fit.rms_px[*i][0], fit.rms_px[*i][1]);
    out.dropped.push_back(
        {out.used[*i],
         fmt::format("deviates by {:.2f} px from the others: blurred, bent, of another board or "
                     "camera{}",
                     miss_px,
                     out.is_pair ? ", or the board moved between the exposures of a pair" : "")});
    out.used.erase(out.used.begin() + static_cast<std::ptrdiff_t>(*i));
    used.erase(used.begin() + static_cast<std::ptrdiff_t>(*i));
    fit = FitRig(board, used, sizes);
  }
  out.rig = fit.rig;
  out.rms_px = fit.rms_px;
  out.sigma = SigmaOf(board, used, sizes);
  SetVerdict(board, different - used.size(), &out);
  return out;
}

}  // namespace palpate
