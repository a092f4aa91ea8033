#include "slave/vision/calibration/registration.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "slave/statistics/robust.h"

namespace palpate {
namespace {

using Indices = std::vector<Eigen::Index>;  // of positions

// Positions of the tip in S, and the same in the camera's frame without its pose [m], or in the
// image of a plane [px]. One per column.
struct Tips {
  Eigen::Matrix3Xd in_S, in_camera;
  bool is_plane = false;
  [[nodiscard]] Eigen::Index dimensions() const { return is_plane ? 2 : 3; }
  [[nodiscard]] std::size_t fewest() const { return is_plane ? 2 : 3; }
};

struct Pose {
  Eigen::Isometry3d X_SC = Eigen::Isometry3d::Identity();
  double scale = 1;  // [m/px] of a plane, else 1
  [[nodiscard]] double Miss(const Tips& tips, Eigen::Index i) const {
    const Eigen::Vector3d p_S = X_SC * (scale * tips.in_camera.col(i));
    return (p_S - tips.in_S.col(i)).head(tips.dimensions()).norm();
  }
};

// Least squares (Umeyama, PAMI 13, 1991). nullopt: the positions determine no pose.
std::optional<Pose> Solve(const Tips& tips, const Indices& which) {
  if (which.size() < tips.fewest()) return std::nullopt;
  const Eigen::Index n = tips.dimensions();
  const Eigen::MatrixXd from = tips.in_camera(Eigen::seqN(0, n), which);
  const Eigen::MatrixXd to = tips.in_S(Eigen::seqN(0, n), which);
  const Eigen::MatrixXd X = Eigen::umeyama(from, to, tips.is_plane);
  Pose pose;
  if (tips.is_plane) pose.scale = X.block(0, 0, n, 1).norm();
  if (!(pose.scale > 0) || !X.allFinite()) return std::nullopt;
  pose.X_SC.linear().topLeftCorner(n, n) = X.topLeftCorner(n, n) / pose.scale;
  pose.X_SC.translation().head(n) = X.topRightCorner(n, 1);
  return pose;
}

double RmsOf(const Tips& tips, const Pose& pose, const Indices& which) {
  double sum = 0;
  for (const Eigen::Index i : which) sum += std::pow(pose.Miss(tips, i), 2);
  return std::sqrt(sum / static_cast<double>(which.size()));
}

// Leaves out the position that contradicts the others most, as long as it is beyond three robust
// sigma of a fit without it.
Indices AgreeingPlaces(const Tips& tips) {
  Indices used(static_cast<std::size_t>(tips.in_S.cols()));
  std::iota(used.begin(), used.end(), 0);
  while (used.size() > tips.fewest() + 1) {
    std::vector<double> misses;  // in robust sigma
    for (const Eigen::Index i : used) {
      Indices others = used;
      std::erase(others, i);
      const auto pose = Solve(tips, others);
      std::vector<double> sizes;
      for (const Eigen::Index other : others) {
        sizes.push_back(pose ? pose->Miss(tips, other) : HUGE_VAL);
      }
      misses.push_back(pose ? pose->Miss(tips, i) / (SigmaOfSizes(sizes) + 1e-12) : 0);
    }
    const auto worst = std::ranges::max_element(misses);
    if (*worst <= 3 * (1 + 5 / static_cast<double>(used.size() - tips.fewest()))) break;
    used.erase(used.begin() + (worst - misses.begin()));
  }
  return used;
}

double LargestSigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[2]));
}

// Computes sigmas by the jackknife: from the poses found without one position each.
void SetSigmas(const Tips& tips, const Indices& used, CameraRegistration* r) {
  r->sigma_angle = r->sigma_place = HUGE_VAL;
  if (used.size() <= tips.fewest()) return;
  Eigen::Matrix3d angle = Eigen::Matrix3d::Zero(), place = Eigen::Matrix3d::Zero();
  for (const Eigen::Index left_out : used) {
    Indices rest = used;
    std::erase(rest, left_out);
    const auto pose = Solve(tips, rest);
    if (!pose) return;
    const Eigen::AngleAxisd turn(r->X_SC.linear().transpose() * pose->X_SC.linear());
    const Eigen::Vector3d shift = pose->X_SC.translation() - r->X_SC.translation();
    angle += turn.angle() * turn.angle() * turn.axis() * turn.axis().transpose();
    place += shift * shift.transpose();
  }
  const auto count = static_cast<double>(used.size());
  r->sigma_angle = LargestSigma((count - 1) / count * angle);
  r->sigma_place = LargestSigma((count - 1) / count * place);
}

// Returns the root mean square of the positions along their principal directions, rising [m].
Eigen::Vector3d ExtentsOf(const Tips& tips, const Indices& used) {
  Eigen::Matrix3Xd at = tips.in_S(Eigen::all, used);
  at.colwise() -= at.rowwise().mean().eval();
  const Eigen::Matrix3d scatter = at * at.transpose() / static_cast<double>(used.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
}

void SetVerdict(const Tips& tips, const Indices& used, CameraRegistration* r) {
  constexpr double kWidth = 0.05, kScatter = 0.05, kMirror = 2, kUsedPositions = 2.0 / 3;
  constexpr double kDegree = std::numbers::pi / 180, kAngle = 2 * kDegree;
  const auto reject = [&](bool is_rejected, const std::string& words) {
    if (is_rejected) r->reasons.push_back(words);
  };
  reject(used.size() <= tips.fewest(),
         fmt::format("{} positions are too few to check the result: expected {}", used.size(),
                     tips.fewest() + 1));
  reject(static_cast<double>(used.size()) < kUsedPositions * static_cast<double>(r->used.size()),
         fmt::format("only {} of {} positions agree with each other", used.size(), r->used.size()));
  reject(!(r->sigma_angle <= kAngle),
         fmt::format("the camera's direction has a sigma of {:.2g} deg: expected {:.2g}; use "
                     "positions that are farther apart",
                     r->sigma_angle / kDegree, kAngle / kDegree));
  const Eigen::Vector3d extents = ExtentsOf(tips, used);
  reject(!(r->rms <= kScatter * extents[2]),
         fmt::format("the residual of the positions is {:.3g} mm rms, more than {:.0f} % of their "
                     "spread of {:.3g} mm",
                     1e3 * r->rms, 100 * kScatter, 1e3 * extents[2]));
  if (!(extents[3 - tips.dimensions()] > kWidth * extents[2])) {
    reject(true, tips.is_plane
                     ? "the positions are collinear: they do not show a mirrored image"
                     : "the positions are nearly coplanar or collinear: they do not show a column "
                       "with a wrong sign");
    return;
  }
  Tips mirrored = tips;
  mirrored.in_S.row(0) *= -1;
  const auto other = Solve(mirrored, used);
  reject(other && kMirror * RmsOf(mirrored, *other, used) < r->rms,
         "the positions are a mirror image of the image points: the sign of a column x, y or z is "
         "wrong, or two columns are exchanged");
  const double height = tips.in_S.row(2)(used).cwiseAbs().maxCoeff();
  reject(tips.is_plane && height > kScatter * extents[2],
         fmt::format("a position is {:.3g} mm off the plane z = 0 of S", 1e3 * height));
}

CameraRegistration Register(const Tips& tips) {
  const Indices used = AgreeingPlaces(tips);
  const auto pose = Solve(tips, used);
  if (!pose) {
    throw std::runtime_error(
        fmt::format("{} positions do not determine a camera pose: expected {} or more that are not "
                    "collinear",
                    tips.in_S.cols(), tips.fewest() + 1));
  }
  CameraRegistration out;
  out.X_SC = pose->X_SC;
  if (tips.is_plane) out.pixel = pose->scale;
  for (Eigen::Index i = 0; i < tips.in_S.cols(); ++i) {
    out.residuals.push_back(pose->Miss(tips, i));
    out.used.push_back(std::ranges::find(used, i) != used.end());
  }
  out.rms = RmsOf(tips, *pose, used);
  SetSigmas(tips, used, &out);
  SetVerdict(tips, used, &out);
  return out;
}

// `in_camera`: of a position; nullopt: it has no usable image point.
template <typename InCamera>
Tips TipsOf(const std::vector<TipPlace>& places, bool is_plane, const InCamera& in_camera) {
  const auto count = static_cast<Eigen::Index>(places.size());
  Tips tips{Eigen::Matrix3Xd::Zero(3, count), Eigen::Matrix3Xd::Zero(3, count), is_plane};
  for (Eigen::Index i = 0; i < count; ++i) {
    const TipPlace& place = places[static_cast<std::size_t>(i)];
    const std::optional<Eigen::Vector3d> p = in_camera(place);
    if (!p || !p->allFinite() || !place.p_S.allFinite()) {
      throw std::runtime_error(
          fmt::format("position {}: its rays do not meet, or a number is not finite", i + 1));
    }
    tips.in_S.col(i) = place.p_S;
    tips.in_camera.col(i) = *p;
  }
  return tips;
}

}  // namespace

CameraRegistration RegisterPair(const StereoRig& rig, const std::vector<TipPlace>& places) {
  return Register(TipsOf(places, false, [&](const TipPlace& p) -> std::optional<Eigen::Vector3d> {
    if (!p.right_I) return std::nullopt;
    const auto point = Triangulate(rig, p.left_I, *p.right_I, 1);
    return point ? std::optional(point->p_L) : std::nullopt;
  }));
}

CameraRegistration RegisterPlane(const std::array<int, 2>& size,
                                 const std::vector<TipPlace>& places) {
  return Register(TipsOf(places, true, [&](const TipPlace& p) {
    return std::optional(
        Eigen::Vector3d(p.left_I.x() - 0.5 * (size[0] - 1), 0.5 * (size[1] - 1) - p.left_I.y(), 0));
  }));
}

}  // namespace palpate
