#include "slave/vision/calibration/registration.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <fmt/format.h>
#include <opencv2/calib3d.hpp>

#include "slave/vision/calibration/lens_calibration.h"
#include "slave/vision/calibration/robust_fit.h"
#include "slave/vision/stereo/lens_model.h"
#include "slave/vision/stereo/lens_warp.h"

namespace palpate {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
// Accepted: places at least this wide across their longest direction, at most this uncertain, and
// no more outliers than half of what fits.
constexpr double kWidth = 0.05, kAngle = 2 * std::numbers::pi / 180, kScatter = 0.05;
constexpr double kUsed = 2.0 / 3;

Indices UsedOf(const CameraRegistration& r) {
  Indices used;
  for (std::size_t i = 0; i < r.used.size(); ++i) {
    if (r.used[i]) used.push_back(i);
  }
  return used;
}

// Root mean square extent of the places used along their principal directions, rising [m].
Eigen::Vector3d Extents(const Indices& used, const std::vector<TipPlace>& places) {
  Eigen::Vector3d mean(0, 0, 0);
  for (const std::size_t i : used) mean += places[i].p_S / static_cast<double>(used.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const std::size_t i : used) {
    const Eigen::Vector3d d = places[i].p_S - mean;
    scatter += d * d.transpose() / static_cast<double>(used.size());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
}

CameraRegistration Finish(const RobustFit& fit, bool in_pixels) {
  CameraRegistration out;
  out.X_SC = fit.guess.X_SC;
  out.pixel = fit.guess.pixel;
  out.in_pixels = in_pixels;
  out.residuals = fit.residuals;
  out.used = fit.used;
  double sum = 0;
  const Indices used = UsedOf(out);
  for (const std::size_t i : used) sum += out.residuals[i] * out.residuals[i];
  out.rms = std::sqrt(sum / static_cast<double>(used.size()));
  return out;
}

void JudgePlaces(const Eigen::Vector3d& extents, std::size_t fewest, CameraRegistration* r) {
  const std::size_t used = UsedOf(*r).size();
  if (used <= fewest) {
    r->reasons.push_back(
        fmt::format("{} places leave nothing to check them by: accepted is {}", used, fewest + 1));
  }
  if (static_cast<double>(used) < kUsed * static_cast<double>(r->used.size())) {
    r->reasons.push_back(
        fmt::format("only {} of {} places agree with each other", used, r->used.size()));
  }
  if (!(extents[1] > kWidth * extents[2])) {
    r->reasons.push_back(
        "the places lie on a line: the turn about it is not defined, and nothing tells a mirror "
        "image");
  }
}

void JudgeScatter(double rms_m, const Eigen::Vector3d& extents, CameraRegistration* r) {
  if (!(r->sigma_angle <= kAngle)) {
    r->reasons.push_back(
        fmt::format("the camera's direction is uncertain by {:.2g} deg (one sigma): accepted is "
                    "{:.2g}; spread the places wider",
                    r->sigma_angle * 180 / std::numbers::pi, kAngle * 180 / std::numbers::pi));
  }
  if (!(rms_m <= kScatter * extents[2])) {
    r->reasons.push_back(fmt::format(
        "the places are off by {:.3g} mm rms, more than {:.0f} % of their spread of {:.3g} mm",
        1e3 * rms_m, 100 * kScatter, 1e3 * extents[2]));
  }
}

// A place above the plane is seen where another one of the plane is.
void JudgeHeights(const Indices& used, const std::vector<TipPlace>& places,
                  const Eigen::Vector3d& extents, CameraRegistration* r) {
  double highest = 0;
  for (const std::size_t i : used) highest = std::max(highest, std::abs(places[i].p_S.z()));
  if (highest <= kScatter * extents[2]) return;
  r->reasons.push_back(fmt::format(
      "a place is {:.3g} mm off the plane z = 0 of S that the camera is to look down on",
      1e3 * highest));
}

Indices All(std::size_t count) {
  Indices all(count);
  for (std::size_t i = 0; i < count; ++i) all[i] = i;
  return all;
}

[[noreturn]] void RefuseTooFew(std::size_t usable, std::size_t fewest) {
  throw std::runtime_error(fmt::format(
      "places that can be used: {}; they define no camera pose: accepted is {} or more that do not "
      "lie on a line",
      usable, fewest + 1));
}

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

Eigen::Vector2d FromCentre(const std::array<int, 2>& size, const Eigen::Vector2d& p_I) {
  return {p_I.x() - 0.5 * (size[0] - 1), 0.5 * (size[1] - 1) - p_I.y()};
}

// `mirror` -1: as if y ran down.
std::optional<CameraGuess> SolvePlane(const std::array<int, 2>& size,
                                      const std::vector<TipPlace>& places, const Indices& which,
                                      double mirror) {
  // Places as complex numbers: to = scale e^(i turn) from + shift, linear in the factor.
  using Complex = std::complex<double>;
  const auto count = static_cast<double>(which.size());
  std::vector<Complex> from, to;
  Complex mean_from = 0, mean_to = 0;
  for (const std::size_t i : which) {
    const Eigen::Vector2d d = FromCentre(size, places[i].left_I);
    from.emplace_back(d.x(), mirror * d.y());
    to.emplace_back(places[i].p_S.x(), places[i].p_S.y());
    mean_from += from.back() / count;
    mean_to += to.back() / count;
  }
  Complex cross = 0;
  double spread = 0;
  for (std::size_t k = 0; k < from.size(); ++k) {
    cross += std::conj(from[k] - mean_from) * (to[k] - mean_to);
    spread += std::norm(from[k] - mean_from);
  }
  const Complex factor = cross / spread;
  const Complex shift = mean_to - factor * mean_from;
  CameraGuess guess;
  guess.pixel = std::abs(factor);
  // Not finite where all of them are one and the same pixel.
  if (!(guess.pixel > 0) || !std::isfinite(guess.pixel)) return std::nullopt;
  guess.X_SC.linear() =
      Eigen::AngleAxisd(std::arg(factor), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  guess.X_SC.translation().head<2>() = Eigen::Vector2d(shift.real(), shift.imag());
  return guess;
}

std::optional<RobustFit> FitPlane(const std::array<int, 2>& size,
                                  const std::vector<TipPlace>& places, double mirror) {
  const auto miss = [&](const CameraGuess& guess, std::size_t i) {
    Eigen::Vector2d d = FromCentre(size, places[i].left_I);
    d.y() *= mirror;
    const Eigen::Vector3d p_S =
        guess.X_SC * Eigen::Vector3d(guess.pixel * d.x(), guess.pixel * d.y(), 0);
    return (p_S - places[i].p_S).head<2>().norm();
  };
  return FitRobustly(
      places.size(), All(places.size()), 2,
      [&](const Indices& which) { return SolvePlane(size, places, which, mirror); }, miss);
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
  CameraRegistration out = Finish(*fit, false);
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
  CameraRegistration out = Finish(*fit, true);
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

CameraRegistration RegisterPlane(const std::array<int, 2>& size,
                                 const std::vector<TipPlace>& places) {
  constexpr std::size_t kFewest = 2;
  const auto fit = places.size() < kFewest ? std::nullopt : FitPlane(size, places, 1);
  if (!fit) RefuseTooFew(places.size(), kFewest);
  CameraRegistration out = Finish(*fit, false);
  const Indices used = UsedOf(out);
  const Eigen::Vector3d extents = Extents(used, places);
  const double across = std::hypot(extents[1], extents[2]);
  out.sigma_angle =
      across > 0 ? out.rms / std::sqrt(2.0) / (across * std::sqrt(static_cast<double>(used.size())))
                 : HUGE_VAL;
  if (const auto mirrored = FitPlane(size, places, -1)) {
    if (Finish(*mirrored, false).rms < 0.3 * out.rms && used.size() > kFewest) {
      out.reasons.emplace_back(
          "the picture is a mirror image of S: accepted is a camera that looks along -z of S");
    }
  }
  JudgePlaces(extents, kFewest, &out);
  JudgeScatter(out.rms, extents, &out);
  JudgeHeights(used, places, extents, &out);
  return out;
}

CameraRegistration RegisterLensPlane(const Lens& lens, const std::vector<TipPlace>& places) {
  std::vector<TipPlace> straight = places;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto at = Straight(lens, places[i].left_I);
    if (!at) {
      throw std::runtime_error(fmt::format(
          "place {}: u, v = {:g}, {:g}: accepted is a pixel of the lens's picture, {} x {}", i + 1,
          places[i].left_I.x(), places[i].left_I.y(), lens.size[0], lens.size[1]));
    }
    straight[i].left_I = *at;
  }
  return RegisterPlane(lens.size, straight);
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
