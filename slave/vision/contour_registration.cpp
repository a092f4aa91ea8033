#include "slave/vision/contour_registration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Cholesky>

#include "slave/statistics/robust.h"

namespace palpate {
namespace {

constexpr int kSteps = 60;
constexpr double kMinScale = 0.02;   // of the errors [px]
constexpr double kMinInliers = 0.4;  // part of the points
// Weight of the prior relative to the points; effect on a block's rotation: 0.1 %.
constexpr double kRotationPrior = 1e-4;
constexpr double kMaxRotation = 0.17;  // [rad]
// Adjacent points share edge pixels, the second next do not. With fewer points than this adjacent
// points are independent [-]. [tuned: SigmaMatchesTheErrorOfTheEdge]
constexpr std::size_t kCloseTogether = 64;
constexpr std::size_t kMaxApart = 5;  // largest distance of correlated points, in points
constexpr int kUnknowns = 3;          // of the rigid motion [by definition]

struct Foot {
  // Unit vector from the outline to the point if their distance is not 0.
  Eigen::Vector2d normal{0, 0};
  double distance = std::numeric_limits<double>::infinity();  // along the normal, signed
};

void Nearer(const std::vector<Eigen::Vector2d>& loop, const Eigen::Vector2d& p, Foot& foot) {
  double nearest2 = foot.distance * foot.distance;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Eigen::Vector2d& a = loop[i];
    const Eigen::Vector2d side = loop[(i + 1) % loop.size()] - a;
    const double length2 = side.squaredNorm();
    if (length2 == 0) continue;
    const double along = std::clamp((p - a).dot(side) / length2, 0.0, 1.0);
    const Eigen::Vector2d away = p - (a + along * side);
    if (away.squaredNorm() >= nearest2) continue;
    nearest2 = away.squaredNorm();
    const Eigen::Vector2d across = Eigen::Vector2d(side.y(), -side.x()) / std::sqrt(length2);
    const bool at_end = along == 0 || along == 1;
    foot.normal = at_end && away.norm() > 0 ? away.normalized() : across;
    foot.distance = away.dot(foot.normal);
  }
}

// Motion (shift, angle, growth) about `centre` from the outline to the points. Applied to points it
// moves them back.
struct Motion {
  Eigen::Vector2d centre, shift{0, 0};
  double angle = 0, scale = 1;
  [[nodiscard]] Eigen::Vector2d Back(const Eigen::Vector2d& p) const {
    return Eigen::Rotation2Dd(-angle) * (p - shift - centre) / scale + centre;
  }
};

class Fitter {
 public:
  // `grows`: whether the size is also fitted.
  Fitter(const Outline& outline, std::vector<Eigen::Vector2d> points, double pixel, bool grows)
      : outline_(outline), points_(std::move(points)), pixel_(pixel), grows_(grows) {
    motion_.centre.setZero();
    for (const Eigen::Vector2d& p : outline.outer) motion_.centre += p;
    motion_.centre /= static_cast<double>(outline.outer.size());
    for (const Eigen::Vector2d& p : outline.outer) {
      size_ = std::max(size_, (p - motion_.centre).norm());
    }
  }

  // The scale of the errors starts at `reach` and shrinks to that of the residuals.
  void Run(double reach) {
    double scale = reach * pixel_;
    for (int step = 0; step < kSteps; ++step) {
      Project();
      std::vector<double> errors;
      for (const Foot& foot : feet_) errors.push_back(std::abs(foot.distance));
      const double shown = std::max(SigmaOfSizes(errors), kMinScale * pixel_);
      scale = std::max(shown, 0.7 * scale);
      if (Step(kBiweightCut * scale) < 1e-5 * pixel_ && scale == shown) break;
    }
    cut_ = kBiweightCut * scale;
    scale_sigma_ *= scale;
    Project();
  }

  [[nodiscard]] const Motion& motion() const { return motion_; }
  [[nodiscard]] double scale_sigma() const { return scale_sigma_; }
  void Report(OutlineFit& fit) const {
    double square = 0;
    for (const Foot& foot : feet_) {
      if (std::abs(foot.distance) > cut_) continue;
      square += foot.distance * foot.distance;
      ++fit.inliers;
    }
    if (fit.inliers == 0) return;
    const double variance = square / fit.inliers;
    fit.rms_px = std::sqrt(variance) / pixel_;
    fit.sigma_px = std::sqrt(ShapeAndFit(variance, fit.inliers)) / pixel_;
  }

 private:
  // Returns the mean product of the distances of points that are `apart` positions from each other
  // [m^2].
  [[nodiscard]] double Shared(std::size_t apart) const {
    double sum = 0;
    int pairs = 0;
    for (std::size_t k = 0; k < feet_.size(); ++k) {
      const double here = feet_[k].distance;
      const double there = feet_[(k + apart) % feet_.size()].distance;
      if (std::abs(here) > cut_ || std::abs(there) > cut_) continue;
      sum += here * there;
      ++pairs;
    }
    return pairs > 0 ? sum / pairs : 0;
  }

  // Variance of the distance between edge and outline [m^2].
  [[nodiscard]] double ShapeAndFit(double variance, int inliers) const {
    const std::size_t count = feet_.size();
    const std::size_t nearest = count < kCloseTogether ? 1 : 2;
    const std::size_t farthest = std::clamp(count / kCloseTogether + 1, nearest, kMaxApart);
    double shape = 0;
    for (std::size_t apart = nearest; apart <= farthest; ++apart) {
      shape += Shared(apart) / static_cast<double>(farthest - nearest + 1);
    }
    shape = std::clamp(shape, 0.0, variance);
    const double noise = variance - shape + 2 * std::max(0.0, Shared(1) - shape);
    return shape + noise * kUnknowns / inliers;
  }

  void Project() {
    feet_.clear();
    for (const Eigen::Vector2d& p : points_) {
      Foot foot;
      Nearer(outline_.outer, motion_.Back(p), foot);
      feet_.push_back(foot);
    }
  }

  // Takes one Gauss-Newton step. Returns the largest motion of the outline [m]. Rotations and
  // growth are measured by the motion of the outline's farthest point. Rotations have a weak prior
  // at zero, because a disc does not determine its rotation.
  double Step(double cut) {
    Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
    Eigen::Vector4d b = Eigen::Vector4d::Zero();
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const Foot& foot = feet_[k];
      const double u = foot.distance / cut;
      if (std::abs(u) >= 1) continue;
      const double weight = Biweight(u);
      const Eigen::Vector2d arm = motion_.Back(points_[k]) - motion_.centre;
      const double turn = (arm.x() * foot.normal.y() - arm.y() * foot.normal.x()) / size_;
      const double growth = grows_ ? arm.dot(foot.normal) / size_ : 0;
      const Eigen::Vector4d J(foot.normal.x(), foot.normal.y(), turn, growth);
      A += weight * J * J.transpose();
      b += weight * J * foot.distance;
    }
    const double hold = kRotationPrior * A.trace();
    A.diagonal() += Eigen::Vector4d(1e-9, 1e-9, hold + 1e-9, 1e-9);
    b(2) -= hold * motion_.angle * size_;
    const Eigen::LDLT<Eigen::Matrix4d> solver(A);
    const Eigen::Vector4d move = solver.solve(b);
    scale_sigma_ = std::sqrt(solver.solve(Eigen::Vector4d::UnitW())(3)) / size_;
    motion_.shift += motion_.scale * (Eigen::Rotation2Dd(motion_.angle) * move.head<2>());
    motion_.angle += move.z() / size_;
    motion_.scale *= std::exp(std::clamp(move.w() / size_, -0.1, 0.1));
    return move.cwiseAbs().maxCoeff();
  }

  const Outline& outline_;
  std::vector<Eigen::Vector2d> points_;  // in the scene's frame O
  double pixel_;
  bool grows_;
  double scale_sigma_ = 0;
  double size_ = 0;  // size of the outline [m]
  double cut_ = 0;
  Motion motion_;
  std::vector<Foot> feet_;
};

}  // namespace

OutlineFit FitOutline(const Outline& outline, const Eigen::Isometry3d& X_SO, CurveView contour_I,
                      const CameraView& view, double reach) {
  OutlineFit fit;
  fit.X_SO = X_SO;
  if (outline.outer.size() < 3 || contour_I.size() < 8) return fit;
  std::vector<Eigen::Vector2d> points;
  const Eigen::Isometry3d X_OS = X_SO.inverse();
  for (const Eigen::Vector2d& p_I : contour_I)
    points.push_back((X_OS * view.ToSlave(p_I)).head<2>());
  Fitter sizer(outline, points, view.pixel(), true);
  sizer.Run(reach);
  fit.scale = sizer.motion().scale;
  fit.scale_sigma = sizer.scale_sigma();
  Fitter fitter(outline, std::move(points), view.pixel(), false);
  fitter.Run(reach);
  fitter.Report(fit);

  const Motion& motion = fitter.motion();
  // Transformation from the scene's frame O to the fitted one.
  Eigen::Isometry3d X_OO = Eigen::Isometry3d::Identity();
  const Eigen::Rotation2Dd turn(motion.angle);
  X_OO.linear().topLeftCorner<2, 2>() = turn.toRotationMatrix();
  X_OO.translation().head<2>() = motion.shift + motion.centre - turn * motion.centre;
  const bool credible = motion.shift.norm() <= reach * view.pixel() &&  // false for NaN
                        std::abs(motion.angle) <= kMaxRotation &&
                        fit.inliers >= kMinInliers * static_cast<double>(contour_I.size());
  if (!credible) return fit;
  fit.found = true;
  fit.X_SO = X_SO * X_OO;
  return fit;
}

std::vector<Eigen::Vector2d> ToSlave(CurveView contour_I, const CameraView& view) {
  std::vector<Eigen::Vector2d> polygon;
  for (const Eigen::Vector2d& p_I : contour_I) polygon.push_back(view.ToSlave(p_I).head<2>());
  if (CurveArea(polygon) < 0) std::reverse(polygon.begin(), polygon.end());
  return polygon;
}

}  // namespace palpate
