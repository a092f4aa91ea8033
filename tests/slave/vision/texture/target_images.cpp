#include "tests/slave/vision/texture/target_images.h"

#include <cmath>
#include <optional>

#include <Eigen/LU>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace palpate {
namespace {

constexpr double kNoise = 2, kBlur = 0.7, kBehind = 60;
constexpr int kSpare = 256;  // of the noise beyond an image's size [px]

// The point of the surface visible at p_I, frame B [m]. nullopt: the body is not there.
std::optional<Eigen::Vector3d> PointAt(const simulation::TexturedTarget& target, const Lens& lens,
                                       const Eigen::Isometry3d& X_CB, const Eigen::Vector2d& p_I) {
  const auto ray = RayOf(lens, p_I);
  if (!ray) return std::nullopt;
  const Eigen::Isometry3d X_BC = X_CB.inverse();
  const Eigen::Vector3d o = X_BC.translation();
  const Eigen::Vector3d d = X_BC.linear() * ray->homogeneous();
  const std::vector<Eigen::Vector3d>& p_B = target.vertices();
  std::optional<Eigen::Vector3d> nearest;
  double least = 0;
  for (const auto& [i, j, k] : target.triangles()) {  // o + s d = a + u (b - a) + v (c - a)
    const Eigen::Vector3d& a = p_B[static_cast<std::size_t>(i)];
    Eigen::Matrix3d M;
    M << -d, p_B[static_cast<std::size_t>(j)] - a, p_B[static_cast<std::size_t>(k)] - a;
    if (std::abs(M.determinant()) < 1e-15) continue;  // edge on
    const Eigen::Vector3d suv = M.inverse() * (o - a);
    constexpr double kRim = -1e-9;
    const bool within = suv.y() >= kRim && suv.z() >= kRim && suv.y() + suv.z() <= 1 - kRim;
    if (!within || !(suv.x() > 0) || (nearest && suv.x() >= least)) continue;
    least = suv.x();
    nearest = o + least * d;
  }
  return nearest;
}

}  // namespace

// S is oriented like a camera midway between both, with its origin at the point at which both look.
TargetImages::TargetImages() : target_(simulation::TexturedTarget::Shape{}) {
  noise_.create(rig.left.size[1] + kSpare, rig.left.size[0] + kSpare, CV_32F);
  random_.fill(noise_, cv::RNG::NORMAL, 0, kNoise);
}

Eigen::Isometry3d TargetImages::X_SB(const Eigen::Vector3d& p_S,
                                     const Eigen::Vector3d& turn) const {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  const double tip =
      simulation::TexturedTarget::Shape{}.semi_axes.z();  // its tip rests at S's origin
  X.translation() = p_S + Eigen::Vector3d(0, 0, tip);
  if (turn.norm() > 0) {
    X.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  }
  return X;
}

cv::Mat TargetImages::Finish(const cv::Mat& canvas) {
  cv::GaussianBlur(canvas, blurred_, {7, 7}, kBlur);
  const int x = random_.uniform(0, kSpare), y = random_.uniform(0, kSpare);
  cv::Mat image;
  cv::Mat seen = blurred_ + noise_(cv::Rect(x, y, canvas.cols, canvas.rows));
  seen.convertTo(image, CV_8U);
  return image;
}

TargetImages::Pair TargetImages::Take(const Eigen::Vector3d& p_S, const Eigen::Vector3d& turn) {
  const Eigen::Isometry3d X_LB = X_SL.inverse() * X_SB(p_S, turn);
  const auto take = [&](const Lens& lens, const Eigen::Isometry3d& X_CB) {
    canvas_.create(lens.size[1], lens.size[0], CV_32F);
    canvas_.setTo(kBehind);
    target_.Draw(lens, X_CB, canvas_);
    return Finish(canvas_);
  };
  return {take(rig.left, X_LB), take(rig.right, rig.X_RL * X_LB)};
}

Eigen::Vector3d TargetImages::PointOf(const Eigen::Vector2d& p_I, const Eigen::Vector3d& from,
                                      const Eigen::Vector3d& to) const {
  const auto p_B = PointAt(target_, rig.left, X_SL.inverse() * X_SB(from, {0, 0, 0}), p_I);
  return X_SB(to, {0, 0, 0}) * p_B.value();
}

}  // namespace palpate
