#include "slave/vision/edge_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace palpate {
namespace {

constexpr int kRays = 128, kSizes = 97;
constexpr double kMaxLarger = 0.8;  // logarithm of 2.2, because a corner is far from a circle
constexpr double kPathBlur = 1.5;   // blur against noise and fine texture [px]
constexpr int kMaxJump = 2;         // largest change of the size index between adjacent rays
// Cost of a change by one; the cost is proportional to the square of the change.
constexpr float kJumpCost = 0.06F;
constexpr float kFar = 0.15F;    // cost of the largest and the smallest size
constexpr float kAnEdge = 0.2F;  // smallest limited gradient of an edge

// Limited gradients along the rays, outwards: kRays x kSizes.
struct Rays {
  Eigen::Vector2d middle{0, 0};
  std::vector<Eigen::Vector2d> ways;  // vectors from the centre to the guide [px]
  std::vector<float> across;

  [[nodiscard]] static double SizeOf(int j) {
    return std::exp(kMaxLarger * (2.0 * j / (kSizes - 1) - 1));
  }
  [[nodiscard]] Eigen::Vector2d At(int ray, int j) const {
    return middle + SizeOf(j) * ways[static_cast<std::size_t>(ray)];
  }
};

Eigen::Vector2d MiddleOf(CurveView curve) {
  Eigen::Vector2d sum(0, 0);
  double area = 0;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const Eigen::Vector2d a = curve[i] - curve[0], b = curve[(i + 1) % curve.size()] - curve[0];
    const double part = a.x() * b.y() - a.y() * b.x();
    sum += part * (a + b) / 3;
    area += part;
  }
  return area == 0 ? curve[0] : (curve[0] + sum / area).eval();
}

// The gradient with its magnitude limited to 0 ... 1 by saturation.
class LimitedGradient {
 public:
  explicit LimitedGradient(const cv::Mat& image) {
    cv::Mat smooth;
    cv::GaussianBlur(image, smooth, {}, kPathBlur);
    cv::Sobel(smooth, gx_, CV_32F, 1, 0, 3, 0.125);
    cv::Sobel(smooth, gy_, CV_32F, 0, 1, 3, 0.125);
    cv::magnitude(gx_, gy_, magnitude_);
    half_ = static_cast<float>(2 * cv::mean(magnitude_)[0] + 0.1);
  }
  // Returns the component along the unit vector `n`; 0 outside the image.
  [[nodiscard]] float Along(const Eigen::Vector2d& p, const Eigen::Vector2d& n) const {
    const bool inside =
        p.x() >= 1 && p.y() >= 1 && p.x() < gx_.cols - 1 && p.y() < gx_.rows - 1;  // false for NaN
    if (!inside) return 0;
    const cv::Point at(cvRound(p.x()), cvRound(p.y()));
    const auto g = gx_.at<float>(at) * static_cast<float>(n.x()) +
                   gy_.at<float>(at) * static_cast<float>(n.y());
    return g / (magnitude_.at<float>(at) + half_);
  }

 private:
  cv::Mat gx_, gy_, magnitude_;
  float half_ = 0;
};

Rays SampleRays(const cv::Mat& image, CurveView guide) {
  const LimitedGradient gradient(image);
  Rays rays;
  rays.middle = MiddleOf(guide);
  rays.across.reserve(static_cast<std::size_t>(kRays * kSizes));
  for (const Eigen::Vector2d& p : Resample(guide, kRays)) rays.ways.push_back(p - rays.middle);
  for (int ray = 0; ray < kRays; ++ray) {
    const Eigen::Vector2d n = rays.ways[static_cast<std::size_t>(ray)].stableNormalized();
    for (int j = 0; j < kSizes; ++j) rays.across.push_back(gradient.Along(rays.At(ray, j), n));
  }
  return rays;
}

void Count(float edge, double share, EdgePath* path) {
  path->strength += share * static_cast<double>(edge);
  path->closedness += edge > kAnEdge ? share : 0;
}

// Returns the best closed chain of sizes: the central half of the best chain over two turns.
std::vector<int> BestChain(const Rays& rays, float sign) {
  constexpr int kColumns = 2 * kRays;  // [by definition]
  std::vector<float> sum(static_cast<std::size_t>(kColumns * kSizes));
  std::vector<int> from(sum.size(), 0);
  for (int c = 0; c < kColumns; ++c) {
    for (int j = 0; j < kSizes; ++j) {
      const auto here = static_cast<std::size_t>(c * kSizes + j);
      const float off = std::abs(2 * static_cast<float>(j) / (kSizes - 1) - 1);
      const float own = sign * rays.across[static_cast<std::size_t>((c % kRays) * kSizes + j)];
      float best = c == 0 ? 0 : -std::numeric_limits<float>::infinity();
      for (int i = std::max(0, j - kMaxJump); c > 0 && i <= std::min(kSizes - 1, j + kMaxJump);
           ++i) {
        const auto step = static_cast<float>(i - j);
        const float offered =
            sum[static_cast<std::size_t>((c - 1) * kSizes + i)] - kJumpCost * step * step;
        if (offered > best) best = offered, from[here] = i;
      }
      sum[here] = best + own - kFar * off;
    }
  }
  const auto last = sum.end() - kSizes;
  int j = static_cast<int>(std::max_element(last, sum.end()) - last);
  std::vector<int> chain(kRays);
  for (int c = kColumns - 1; c >= 0; --c) {
    if (c >= kRays / 2 && c < kRays / 2 + kRays) chain[static_cast<std::size_t>(c % kRays)] = j;
    j = from[static_cast<std::size_t>(c * kSizes + j)];
  }
  return chain;
}

}  // namespace

EdgePath FollowEdgeAround(const cv::Mat& image, CurveView guide) {
  EdgePath best;
  if (guide.size() < 3 || !(CurveLength(guide) > 0)) return best;
  const Rays rays = SampleRays(image, guide);
  for (const float sign : {-1.0F, 1.0F}) {
    const std::vector<int> chain = BestChain(rays, sign);
    EdgePath path;
    for (int ray = 0; ray < kRays; ++ray) {
      const int j = chain[static_cast<std::size_t>(ray)];
      const float edge = sign * rays.across[static_cast<std::size_t>(ray * kSizes + j)];
      path.curve.push_back(rays.At(ray, j));
      Count(edge, 1.0 / kRays, &path);
    }
    if (path.strength > best.strength) best = std::move(path);
  }
  return best;
}

EdgePath MeasureEdge(const cv::Mat& image, CurveView curve) {
  EdgePath best;
  if (curve.size() < 3 || !(CurveLength(curve) > 0)) return best;
  const LimitedGradient gradient(image);
  const Curve even = Resample(curve, kRays);
  for (const float sign : {-1.0F, 1.0F}) {
    EdgePath path{even, 0, 0};
    for (std::size_t i = 0; i < even.size(); ++i) {
      const Eigen::Vector2d t =
          even[(i + 1) % even.size()] - even[(i + even.size() - 1) % even.size()];
      const Eigen::Vector2d n = Eigen::Vector2d(t.y(), -t.x()).stableNormalized();
      Count(sign * gradient.Along(even[i], n), 1.0 / kRays, &path);
    }
    if (path.strength > best.strength) best = std::move(path);
  }
  return best;
}

}  // namespace palpate
