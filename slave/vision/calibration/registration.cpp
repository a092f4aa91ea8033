#include "slave/vision/calibration/registration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <fmt/format.h>
#include <opencv2/calib3d.hpp>

#include "slave/vision/calibration/lens_calibration.h"
#include "slave/vision/calibration/registration_checks.h"
#include "slave/vision/stereo/lens_model.h"

namespace palpate {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::optional<CameraGuess> SolvePnp(const Lens& lens, const std::vector<TipPlace>& places,
                                    const Indices& which) {
  std::vector<cv::Point3d> objects;
  std::vector<cv::Point2d> pictures;
  for (const std::size_t i : which) {
    const TipPlace& at = places[i];
    objects.emplace_back(at.p_S.x(), at.p_S.y(), at.p_S.z());
    pictures.emplace_back(at.left_I.x(), at.left_I.y());
  }
  try {
    cv::Mat rotation, translation;
    const cv::Matx33d K = CameraMatrixOf(lens);
    const cv::Mat D = DistortionOf(lens);
    if (!cv::solvePnP(objects, pictures, K, D, rotation, translation, false, cv::SOLVEPNP_SQPNP)) {
      return std::nullopt;
    }
    cv::solvePnPRefineLM(objects, pictures, K, D, rotation, translation);
    return CameraGuess{PoseOf(rotation, translation).inverse(), 0};
  } catch (const std::exception&) {  // cv::Exception or no finite pose
    return std::nullopt;
  }
}

// One sigma of the pose's angle [rad] and place [m] from the pictures' misses, by the curvature of
// their squares.
void SetSigmas(const Lens& lens, const std::vector<TipPlace>& places, CameraRegistration* r) {
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  const Eigen::Isometry3d X_CS = r->X_SC.inverse();
  const Indices used = UsedOf(*r);
  for (const std::size_t i : used) {
    const Eigen::Vector3d p_C = X_CS * places[i].p_S;
    Eigen::Vector2d at;
    Eigen::Matrix<double, 2, 3> by_place;
    if (!ProjectWithJacobian(lens, p_C, &at, &by_place)) continue;
    Eigen::Matrix3d cross;  // turning the camera moves the place across
    cross << 0, -p_C.z(), p_C.y(), p_C.z(), 0, -p_C.x(), -p_C.y(), p_C.x(), 0;
    Eigen::Matrix<double, 2, 6> J;
    J << -by_place * cross, by_place;
    normal += J.transpose() * J;
  }
  const double spare = std::max(1.0, 2.0 * static_cast<double>(used.size()) - 6);
  const double variance = r->rms * r->rms * static_cast<double>(used.size()) / spare;
  const Eigen::Matrix<double, 6, 6> covariance = variance * normal.inverse();
  const auto largest = [](const Eigen::Matrix3d& block) {
    if (!block.allFinite()) return std::numeric_limits<double>::infinity();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(block, Eigen::EigenvaluesOnly);
    return std::sqrt(std::max(0.0, solver.eigenvalues()[2]));
  };
  r->sigma_angle = largest(covariance.topLeftCorner<3, 3>());
  r->sigma_place = largest(covariance.bottomRightCorner<3, 3>());
}

// The rigid motion from p_L to the places in S of least squares (Kabsch 1976).
std::optional<CameraGuess> Kabsch(const std::vector<Eigen::Vector3d>& p_L,
                                  const std::vector<TipPlace>& places, const Indices& which) {
  const auto count = static_cast<double>(which.size());
  Eigen::Vector3d mean_L(0, 0, 0), mean_S(0, 0, 0);
  for (const std::size_t i : which) {
    mean_L += p_L[i] / count;
    mean_S += places[i].p_S / count;
  }
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  for (const std::size_t i : which) {
    cross += (places[i].p_S - mean_S) * (p_L[i] - mean_L).transpose();
  }
  if (!cross.allFinite()) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
  if (R.determinant() < 0) {  // a mirror image fits best: the nearest rotation instead
    Eigen::Matrix3d U = svd.matrixU();
    U.col(2) *= -1;
    R = U * svd.matrixV().transpose();
  }
  CameraGuess guess;
  guess.X_SC.linear() = R;
  guess.X_SC.translation() = mean_S - R * mean_L;
  return guess;
}

}  // namespace

CameraRegistration RegisterPair(const StereoRig& rig, const std::vector<TipPlace>& places) {
  constexpr std::size_t kFewest = 3;
  std::vector<Eigen::Vector3d> p_L(places.size(), Eigen::Vector3d::Zero());
  Indices usable;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!places[i].right_I) continue;
    const auto point = Triangulate(rig, places[i].left_I, *places[i].right_I, 1);
    if (!point) continue;
    p_L[i] = point->p_L;
    usable.push_back(i);
  }
  const auto solve = [&](const Indices& which) { return Kabsch(p_L, places, which); };
  const auto miss = [&](const CameraGuess& guess, std::size_t i) {
    return (guess.X_SC * p_L[i] - places[i].p_S).norm();
  };
  const auto fit = usable.size() < kFewest
                       ? std::nullopt
                       : FitRobustly(places.size(), usable, kFewest, solve, miss);
  if (!fit) RefuseTooFew(usable.size(), kFewest);
  CameraRegistration out = RegistrationOf(*fit, false);
  const Indices used = UsedOf(out);
  const Eigen::Vector3d extents = Extents(used, places);
  // A turn about the longest direction moves the places by their extent across it.
  const double root = std::sqrt(static_cast<double>(used.size()));
  const double across = std::hypot(extents[0], extents[1]);
  out.sigma_angle = across > 0 ? out.rms / std::sqrt(3.0) / (across * root) : HUGE_VAL;
  const Eigen::Vector3d first_S = places[used.front()].p_S;
  out.sigma_place = std::hypot(out.rms / std::sqrt(3.0) / root,
                               out.sigma_angle * (out.X_SC.translation() - first_S).norm());
  JudgePlaces(extents, kFewest, &out);
  JudgeScatter(out.rms, extents, &out);
  return out;
}

CameraRegistration RegisterLens(const Lens& lens, const std::vector<TipPlace>& places) {
  constexpr std::size_t kFewest = 4;
  Indices usable;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (RayOf(lens, places[i].left_I)) usable.push_back(i);
  }
  const auto miss = [&](const CameraGuess& guess, std::size_t i) {
    const auto at = Project(lens, guess.X_SC.inverse() * places[i].p_S);
    return at ? (*at - places[i].left_I).norm() : kNan;
  };
  const auto solve = [&](const Indices& which) { return SolvePnp(lens, places, which); };
  const auto fit = usable.size() < kFewest
                       ? std::nullopt
                       : FitRobustly(places.size(), usable, kFewest, solve, miss);
  if (!fit) RefuseTooFew(usable.size(), kFewest);
  CameraRegistration out = RegistrationOf(*fit, true);
  SetSigmas(lens, places, &out);
  const Indices used = UsedOf(out);
  const Eigen::Vector3d extents = Extents(used, places);
  double distance = 0;  // [m], mean
  for (const std::size_t i : used) {
    distance += (out.X_SC.inverse() * places[i].p_S).z() / static_cast<double>(used.size());
  }
  JudgePlaces(extents, kFewest, &out);
  JudgeScatter(out.rms * distance / std::sqrt(lens.fx * lens.fy), extents, &out);
  return out;
}

std::string ScenePose(const Eigen::Isometry3d& X) {
  const Eigen::Matrix3d R = X.linear();
  constexpr double kDegrees = 180 / std::numbers::pi;
  // R = Rz Ry Rx; at Ry = 90 deg x and z turn about the same axis: all is given to z.
  const double across = std::hypot(R(0, 0), R(1, 0));
  const bool is_gimbal = across < 1e-9;
  const double x = is_gimbal ? 0 : std::atan2(R(2, 1), R(2, 2));
  const double y = std::atan2(-R(2, 0), across);
  const double z = is_gimbal ? std::atan2(-R(0, 1), R(1, 1)) : std::atan2(R(1, 0), R(0, 0));
  const Eigen::Vector3d t = 1e3 * X.translation();
  return fmt::format(
      "pose: {{translation: [{:.6g} mm, {:.6g} mm, {:.6g} mm], rotation: [{:.8g} deg, {:.8g} deg, "
      "{:.8g} deg]}}",
      // + 0.0: no "-0" is printed
      t.x() + 0.0, t.y() + 0.0, t.z() + 0.0, x * kDegrees + 0.0, y * kDegrees + 0.0,
      z * kDegrees + 0.0);
}

}  // namespace palpate
