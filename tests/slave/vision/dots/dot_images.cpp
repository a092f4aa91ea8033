#include "tests/slave/vision/dots/dot_images.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include "tests/slave/vision/stereo/test_rigs.h"
#include "tests/support/normal_noise.h"

namespace palpate {
namespace {

constexpr int kLines = 16;  // thin scan lines per row

// [first, last] where the line y cuts the conic; empty: first > last.
std::pair<double, double> Chord(const Conic& Q, double y) {
  const double a = Q(0, 0), b = Q(0, 1) * y + Q(0, 2);
  const double c = Q(1, 1) * y * y + 2 * Q(1, 2) * y + Q(2, 2);
  const double root = b * b - a * c;
  if (root <= 0) return {1, 0};
  return {(-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a};
}

void Cover(const Conic& Q, int width, int height, std::vector<double>* coverage) {
  for (int line = 0; line < height * kLines; ++line) {
    const double y = (line + 0.5) / kLines - 0.5;
    const auto [first, last] = Chord(Q, y);
    const int begin = std::max(0, static_cast<int>(std::floor(first + 0.5)));
    const int end = std::min(width - 1, static_cast<int>(std::ceil(last - 0.5)));
    for (int x = begin; x <= end && first < last; ++x) {
      const double share = std::min(last, x + 0.5) - std::max(first, x - 0.5);
      (*coverage)[static_cast<std::size_t>(line / kLines * width + x)] +=
          std::max(0.0, share) / kLines;
    }
  }
}

// Returns the fraction of the pixel's subsamples that lie in the half-plane.
double ShareBeyond(const DotImage::Beyond& edge, int x, int y) {
  const double off = edge.n.dot(Eigen::Vector2d(x, y)) - edge.offset;
  if (std::abs(off) > 1) return off > 0 ? 1 : 0;
  int inside = 0;
  for (int i = 0; i < kLines; ++i) {
    for (int j = 0; j < kLines; ++j) {
      const Eigen::Vector2d step((i + 0.5) / kLines - 0.5, (j + 0.5) / kLines - 0.5);
      if (off + edge.n.dot(step) > 0) ++inside;
    }
  }
  return inside / static_cast<double>(kLines * kLines);
}

}  // namespace

Conic Ellipse(const Eigen::Vector2d& centre, double a, double b, double angle) {
  Eigen::Matrix3d T = Eigen::Matrix3d::Identity();
  T.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(-angle).toRotationMatrix();
  T.topRightCorner<2, 1>() = -T.topLeftCorner<2, 2>() * centre;
  return T.transpose() * Eigen::Vector3d(1 / (a * a), 1 / (b * b), -1).asDiagonal() * T;
}

// A ray d meets the plane at d (n . c) / (n . d); inside the disc the intersection is closer to c
// than r.
Conic DiscSeen(const Lens& lens, const Eigen::Vector3d& p_C, const Eigen::Vector3d& n_C,
               double radius) {
  Eigen::Matrix3d to_ray = Eigen::Matrix3d::Identity();
  to_ray << 1 / lens.fx, 0, -lens.cx / lens.fx, 0, 1 / lens.fy, -lens.cy / lens.fy, 0, 0, 1;
  const Eigen::Matrix3d A = n_C.dot(p_C) * Eigen::Matrix3d::Identity() - p_C * n_C.transpose();
  const Eigen::Matrix3d Q = A.transpose() * A - radius * radius * n_C * n_C.transpose();
  return to_ray.transpose() * Q * to_ray;
}

cv::Mat DotImage::Render(std::uint64_t seed) const {
  std::vector<double> coverage(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (const Conic& Q : dots) Cover(Q, width, height, &coverage);
  std::vector<double> levels(coverage.size());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto i = static_cast<std::size_t>(y * width + x);
      levels[i] = ground + (dot - ground) * coverage[i];
      for (const Beyond& edge : edges) {
        levels[i] += (edge.level - levels[i]) * ShareBeyond(edge, x, y);
      }
    }
  }
  if (blur > 0) {
    cv::Mat sharp(height, width, CV_64F, levels.data());
    const int size = 2 * static_cast<int>(std::ceil(4 * blur)) + 1;
    cv::GaussianBlur(sharp.clone(), sharp, {size, size}, blur, blur, cv::BORDER_REPLICATE);
  }
  std::mt19937_64 random(seed);
  NormalNoise gaussian;
  cv::Mat image(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double light = 1 - light_fall * x / width;
      const double level =
          light * levels[static_cast<std::size_t>(y * width + x)] + noise * gaussian(random);
      image.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(std::clamp(std::lround(level), 0L, 255L));
    }
  }
  return image;
}

std::vector<Conic> ArraySeen(int eye, const std::vector<Eigen::Vector3d>& places,
                             const std::vector<Eigen::Vector3d>& normals, double radius) {
  const Eigen::Isometry3d X_CO = VergedPose(eye == 0 ? -1 : 1).inverse();
  std::vector<Conic> seen;
  for (std::size_t k = 0; k < places.size(); ++k) {
    seen.push_back(DiscSeen(SceneLens(), X_CO * places[k], X_CO.linear() * normals[k], radius));
  }
  return seen;
}

}  // namespace palpate
