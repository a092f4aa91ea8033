#include "slave/vision/calibration/registration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <opencv2/calib3d.hpp>

#include "slave/vision/calibration/lens_calibration.h"
#include "slave/vision/calibration/robust_fit.h"
#include "slave/vision/stereo/lens_warp.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {
namespace {

// Accepted: places at least this wide across their longest direction, at most this uncertain, and
// no more outliers than half of what fits.
constexpr double kWidth = 0.05, kAngle = 2 * std::numbers::pi / 180, kScatter = 0.05;
constexpr double kUsed = 2.0 / 3;
// Two fits of the same places are alike where their misses differ by less than this factor.
constexpr double kAlike = 2;

Indices AllIndices(std::size_t count) {
  Indices all(count);
  for (std::size_t i = 0; i < count; ++i) all[i] = i;
  return all;
}

Indices UsedOf(const CameraRegistration& r) {
  Indices used;
  for (std::size_t i = 0; i < r.used.size(); ++i) {
    if (r.used[i]) used.push_back(i);
  }
  return used;
}

// Positions and their principal directions.
struct PlaceCloud {
  Eigen::Vector3d mean{0, 0, 0};
  Eigen::Vector3d extents{0, 0, 0};  // root mean square along the directions, rising [m]
  Eigen::Vector3d normal{0, 0, 1};   // the direction of the smallest extent
};

PlaceCloud CloudOf(const Indices& used, const std::vector<TipPlace>& places) {
  PlaceCloud cloud;
  for (const std::size_t i : used) cloud.mean += places[i].p_S / static_cast<double>(used.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const std::size_t i : used) {
    const Eigen::Vector3d d = places[i].p_S - cloud.mean;
    scatter += d * d.transpose() / static_cast<double>(used.size());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  cloud.extents = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  cloud.normal = solver.eigenvectors().col(0);
  return cloud;
}

CameraRegistration RegistrationOf(const RobustFit& fit, bool in_pixels) {
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

double SumOfSquares(const CameraRegistration& r) {
  return r.rms * r.rms * static_cast<double>(UsedOf(r).size());
}

void SetSigmas(const PoseNoise& noise, CameraRegistration* r) {
  const PoseNoise::Sigmas sigmas = noise.Of(SumOfSquares(*r));
  r->sigma_angle = sigmas.angle;
  r->sigma_place = sigmas.place;
}

// d p_C / d (turn, shift) of the camera.
Eigen::Matrix<double, 3, 6> ByPose(const Eigen::Vector3d& p_C) {
  Eigen::Matrix<double, 3, 6> J;
  J.leftCols<3>() << 0, -p_C.z(), p_C.y(), p_C.z(), 0, -p_C.x(), -p_C.y(), p_C.x(), 0;
  J.rightCols<3>().setIdentity();
  return J;
}

// The images' noise is the same in all of them.
PoseNoise NoiseOf(const Lens& lens, const std::vector<TipPlace>& places,
                  const CameraRegistration& r) {
  PoseNoise noise;
  const Eigen::Isometry3d X_CS = r.X_SC.inverse();
  for (const std::size_t i : UsedOf(r)) {
    const Eigen::Vector3d p_C = X_CS * places[i].p_S;
    Eigen::Vector2d at;
    Eigen::Matrix<double, 2, 3> by_place;
    if (!ProjectWithJacobian(lens, p_C, &at, &by_place)) continue;
    noise.Add(by_place * ByPose(p_C), Eigen::Matrix2d::Identity());
  }
  return noise;
}

// Least squares by Eigen::umeyama: p_S = X_SC p_C of points [m], one column each.
CameraGuess FitRigid(const Eigen::Matrix3Xd& p_C, const Eigen::Matrix3Xd& p_S) {
  return {Eigen::Isometry3d(Eigen::umeyama(p_C, p_S, false)), 0};
}

// Least squares by Eigen::umeyama of a camera above z = 0: p_S = X_SC (pixel d), with `d_px` right
// and up from the image's centre. nullopt: all image points are the same.
std::optional<CameraGuess> FitSimilarity(const Eigen::Matrix2Xd& d_px,
                                         const Eigen::Matrix2Xd& p_S) {
  const Eigen::Matrix3d X = Eigen::umeyama(d_px, p_S, true);
  CameraGuess guess;
  guess.pixel = X.block<2, 1>(0, 0).norm();
  if (!(guess.pixel > 0) || !X.allFinite()) return std::nullopt;
  guess.X_SC.linear().topLeftCorner<2, 2>() = X.topLeftCorner<2, 2>() / guess.pixel;
  guess.X_SC.translation().head<2>() = X.topRightCorner<2, 1>();
  return guess;
}

// Places on a plane, seen from afar, may be tilted either way.
void CheckOtherPose(const std::vector<LensPose>& poses, CameraRegistration* r) {
  if (poses.size() < 2) return;
  const Eigen::Matrix3d turn =
      poses[0].guess.X_SC.linear().transpose() * poses[1].guess.X_SC.linear();
  const double angle = Eigen::AngleAxisd(turn).angle();
  constexpr double kSame = 1e-3;  // [rad]: two ways to the same minimum
  const double spare = 2.0 * static_cast<double>(UsedOf(*r).size()) - 6;
  // Accepted: the other one misses by three sigma more.
  const double limit = poses[0].sum_of_squares * (1 + 9 / std::max(spare, 1.0)) + 1e-12;
  if (angle < kSame || poses[1].sum_of_squares > limit) return;
  r->reasons.push_back(
      fmt::format("a second pose, rotated by {:.3g} deg, fits nearly as well ({:.3g} px rms): use "
                  "positions that are not coplanar, or nearer to the camera",
                  angle * 180 / std::numbers::pi,
                  std::sqrt(poses[1].sum_of_squares / static_cast<double>(UsedOf(*r).size()))));
}

// The tips as the pair sees them; noise along the view counts several times that across it.
struct SeenTips {
  std::vector<Eigen::Vector3d> p_L;
  std::vector<Eigen::Matrix3d> covariance;  // for one px of noise [m^2]
  Indices usable;
};

SeenTips Triangulate(const StereoRig& rig, const std::vector<TipPlace>& places) {
  SeenTips seen;
  seen.p_L.resize(places.size(), Eigen::Vector3d::Zero());
  seen.covariance.resize(places.size(), Eigen::Matrix3d::Zero());
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!places[i].right_I) continue;
    const auto point = Triangulate(rig, places[i].left_I, *places[i].right_I, 1);
    if (!point) continue;
    seen.p_L[i] = point->p_L;
    seen.covariance[i] = point->covariance;
    seen.usable.push_back(i);
  }
  return seen;
}

// Error of the places used, were the table their mirror image.
template <typename Solve, typename Miss>
double MirroredRms(const std::vector<TipPlace>& places, const Indices& used, const Solve& solve,
                   const Miss& miss) {
  std::vector<TipPlace> mirrored = places;
  for (TipPlace& place : mirrored) place.p_S.x() *= -1;
  const auto guess = solve(mirrored, used);
  if (!guess) return HUGE_VAL;
  double sum = 0;
  for (const std::size_t i : used) {
    const double m = miss(mirrored, *guess, i);
    sum += std::isfinite(m) ? m * m : HUGE_VAL;
  }
  return std::sqrt(sum / static_cast<double>(used.size()));
}

void RefuseTooFew(std::size_t usable, std::size_t fewest) {
  throw std::runtime_error(
      fmt::format("usable positions: {}; they do not determine a camera pose: expected {} or "
                  "more that are not collinear",
                  usable, fewest + 1));
}

// Collinear, contradicting or few positions; `fewest` positions determine a pose.
void CheckPlaces(const Eigen::Vector3d& extents, std::size_t fewest, CameraRegistration* r) {
  const std::size_t used = UsedOf(*r).size();
  if (used <= fewest) {
    r->reasons.push_back(
        fmt::format("{} positions are too few to check the result: expected {}", used, fewest + 1));
  }
  if (static_cast<double>(used) < kUsed * static_cast<double>(r->used.size())) {
    r->reasons.push_back(
        fmt::format("only {} of {} positions agree with each other", used, r->used.size()));
  }
  if (!(extents[1] > kWidth * extents[2])) {
    r->reasons.push_back(
        "the positions are collinear: the rotation about the line is not determined, and a mirror "
        "image is not detected");
  }
}

// `mirrored_rms`: residual of the used positions for the mirrored table, in the unit of r->rms.
void CheckMirror(double mirrored_rms, const std::vector<TipPlace>& places, CameraRegistration* r) {
  const PlaceCloud cloud = CloudOf(UsedOf(*r), places);
  if (!(cloud.extents[1] > kWidth * cloud.extents[2])) return;  // on a line: stated already
  constexpr double kExact = 1e-9;  // [m] or [px]: both fit without any miss
  if (kAlike * mirrored_rms + kExact < r->rms) {
    r->reasons.push_back(
        "the positions are a mirror image of the image points: the sign of a column x, y or z is "
        "wrong, or two columns are exchanged");
    return;
  }
  if (mirrored_rms > kAlike * r->rms + kExact) return;
  int axis = 0;  // of S, the one the plane faces most
  cloud.normal.cwiseAbs().maxCoeff(&axis);
  const Eigen::Vector3d camera = r->X_SC.translation() - cloud.mean;
  const bool is_greater = camera.dot(cloud.normal) * cloud.normal[axis] > 0;
  const char name = "xyz"[axis];
  r->warnings.push_back(
      fmt::format("the positions are coplanar: a table with a wrong sign or exchanged columns fits "
                  "as well, with the camera on the other side. Check that the camera is {:.3g} mm "
                  "from the plane, on the side where {} of S is {}, and looks towards {}{}",
                  1e3 * std::abs(camera.dot(cloud.normal)), name,
                  is_greater ? "greater" : "smaller", is_greater ? '-' : '+', name));
}

// The robust fit, and what speaks against the places themselves.
template <typename Solve, typename Miss>
CameraRegistration Register(const std::vector<TipPlace>& places, const Indices& usable,
                            std::size_t fewest, const Solve& solve, const Miss& miss,
                            bool in_pixels) {
  const auto fit =
      usable.size() < fewest
          ? std::nullopt
          : FitRobustly(
                places.size(), usable, fewest,
                [&](const Indices& which) { return solve(places, which); },
                [&](const CameraGuess& guess, std::size_t i) { return miss(places, guess, i); });
  if (!fit) RefuseTooFew(usable.size(), fewest);
  CameraRegistration out = RegistrationOf(*fit, in_pixels);
  const Indices used = UsedOf(out);
  CheckPlaces(CloudOf(used, places).extents, fewest, &out);
  CheckMirror(MirroredRms(places, used, solve, miss), places, &out);
  return out;
}

void CheckScatter(double rms_m, const Eigen::Vector3d& extents, CameraRegistration* r) {
  if (!(r->sigma_angle <= kAngle)) {
    r->reasons.push_back(
        fmt::format("the camera's direction has a sigma of {:.2g} deg: expected {:.2g}; use "
                    "positions that are farther apart",
                    r->sigma_angle * 180 / std::numbers::pi, kAngle * 180 / std::numbers::pi));
  }
  if (!(rms_m <= kScatter * extents[2])) {
    r->reasons.push_back(
        fmt::format("the residual of the positions is {:.3g} mm rms, more than {:.0f} % of their "
                    "spread of {:.3g} mm",
                    1e3 * rms_m, 100 * kScatter, 1e3 * extents[2]));
  }
}

// A position above the plane has the image of another point of the plane.
void CheckHeights(const Indices& used, const std::vector<TipPlace>& places,
                  const Eigen::Vector3d& extents, CameraRegistration* r) {
  double highest = 0;
  for (const std::size_t i : used) highest = std::max(highest, std::abs(places[i].p_S.z()));
  if (highest <= kScatter * extents[2]) return;
  r->reasons.push_back(
      fmt::format("a position is {:.3g} mm off the plane z = 0 of S", 1e3 * highest));
}

}  // namespace

CameraRegistration RegisterPair(const StereoRig& rig, const std::vector<TipPlace>& places) {
  constexpr std::size_t kFewest = 3;
  const SeenTips seen = Triangulate(rig, places);
  const auto solve = [&](const std::vector<TipPlace>& table,
                         const Indices& which) -> std::optional<CameraGuess> {
    const auto count = static_cast<Eigen::Index>(which.size());
    Eigen::Matrix3Xd p_L(3, count), p_S(3, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const std::size_t i = which[static_cast<std::size_t>(k)];
      p_L.col(k) = seen.p_L[i], p_S.col(k) = table[i].p_S;
    }
    return FitRigid(p_L, p_S);
  };
  const auto miss = [&](const std::vector<TipPlace>& table, const CameraGuess& guess,
                        std::size_t i) { return (guess.X_SC * seen.p_L[i] - table[i].p_S).norm(); };
  CameraRegistration out = Register(places, seen.usable, kFewest, solve, miss, false);
  PoseNoise noise;
  for (const std::size_t i : UsedOf(out)) noise.Add(ByPose(seen.p_L[i]), seen.covariance[i]);
  SetSigmas(noise, &out);
  CheckScatter(out.rms, CloudOf(UsedOf(out), places).extents, &out);
  return out;
}

CameraRegistration RegisterLens(const Lens& lens, const std::vector<TipPlace>& places) {
  constexpr std::size_t kFewest = 4;
  Indices usable;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (RayOf(lens, places[i].left_I)) usable.push_back(i);
  }
  const auto solve = [&](const std::vector<TipPlace>& table, const Indices& which) {
    const auto poses = LensPoses(lens, table, which);
    return poses.empty() ? std::nullopt : std::optional(poses.front().guess);
  };
  const auto miss = [&](const std::vector<TipPlace>& table, const CameraGuess& guess,
                        std::size_t i) { return LensMiss(lens, guess.X_SC, table[i]); };
  CameraRegistration out = Register(places, usable, kFewest, solve, miss, true);
  SetSigmas(NoiseOf(lens, places, out), &out);
  const Indices used = UsedOf(out);
  double distance = 0;  // [m], mean
  for (const std::size_t i : used) {
    distance += (out.X_SC.inverse() * places[i].p_S).z() / static_cast<double>(used.size());
  }
  CheckOtherPose(LensPoses(lens, places, used), &out);
  CheckScatter(out.rms * distance / std::sqrt(lens.fx * lens.fy), CloudOf(used, places).extents,
               &out);
  return out;
}

CameraRegistration RegisterPlane(const std::array<int, 2>& size,
                                 const std::vector<TipPlace>& places) {
  constexpr std::size_t kFewest = 2;
  const auto from_centre_px = [&](std::size_t i) {
    const Eigen::Vector2d& p_I = places[i].left_I;
    return Eigen::Vector2d(p_I.x() - 0.5 * (size[0] - 1), 0.5 * (size[1] - 1) - p_I.y());
  };
  const auto solve = [&](const std::vector<TipPlace>& table, const Indices& which) {
    const auto count = static_cast<Eigen::Index>(which.size());
    Eigen::Matrix2Xd d_px(2, count), p_S(2, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const std::size_t i = which[static_cast<std::size_t>(k)];
      d_px.col(k) = from_centre_px(i), p_S.col(k) = table[i].p_S.head<2>();
    }
    return FitSimilarity(d_px, p_S);
  };
  const auto miss = [&](const std::vector<TipPlace>& table, const CameraGuess& guess,
                        std::size_t i) {
    Eigen::Vector3d p_C(0, 0, 0);
    p_C.head<2>() = guess.pixel * from_centre_px(i);
    return (guess.X_SC * p_C - table[i].p_S).head<2>().norm();
  };
  CameraRegistration out = Register(places, AllIndices(places.size()), kFewest, solve, miss, false);
  const Indices used = UsedOf(out);
  const Eigen::Vector3d extents = CloudOf(used, places).extents;
  const double across = std::hypot(extents[1], extents[2]);
  out.sigma_angle =
      across > 0 ? out.rms / std::sqrt(2.0) / (across * std::sqrt(static_cast<double>(used.size())))
                 : HUGE_VAL;
  CheckScatter(out.rms, extents, &out);
  CheckHeights(used, places, extents, &out);
  return out;
}

CameraRegistration RegisterLensPlane(const Lens& lens, const std::vector<TipPlace>& places) {
  std::vector<TipPlace> straight = places;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto at = Straight(lens, places[i].left_I);
    if (!at) {
      throw std::runtime_error(fmt::format(
          "row {}: u, v = {:g}, {:g}: expected a pixel of the lens's image, {} x {}", i + 1,
          places[i].left_I.x(), places[i].left_I.y(), lens.size[0], lens.size[1]));
    }
    straight[i].left_I = *at;
  }
  return RegisterPlane(lens.size, straight);
}

double LensMiss(const Lens& lens, const Eigen::Isometry3d& X_SC, const TipPlace& place) {
  const auto at = Project(lens, X_SC.inverse() * place.p_S);
  return at ? (*at - place.left_I).norm() : std::numeric_limits<double>::quiet_NaN();
}

std::vector<LensPose> LensPoses(const Lens& lens, const std::vector<TipPlace>& places,
                                const Indices& which) {
  // About the positions' mean: far from the origin, rotation and translation are hard to tell
  // apart.
  const PlaceCloud cloud = CloudOf(which, places);
  std::vector<cv::Point3d> objects;
  std::vector<cv::Point2d> images;
  for (const std::size_t i : which) {
    const Eigen::Vector3d p = places[i].p_S - cloud.mean;
    objects.emplace_back(p.x(), p.y(), p.z());
    images.emplace_back(places[i].left_I.x(), places[i].left_I.y());
  }
  const cv::Matx33d K = CameraMatrixOf(lens);
  const cv::Mat D = DistortionOf(lens);
  std::vector<LensPose> poses;
  std::vector<cv::SolvePnPMethod> methods{cv::SOLVEPNP_SQPNP, cv::SOLVEPNP_EPNP};
  const bool is_flat = cloud.extents[0] <= kWidth * cloud.extents[2];
  if (is_flat) methods.push_back(cv::SOLVEPNP_IPPE);
  for (const cv::SolvePnPMethod method : methods) {
    try {
      std::vector<cv::Mat> rotations, translations;
      cv::solvePnPGeneric(objects, images, K, D, rotations, translations, false, method);
      for (std::size_t k = 0; k < rotations.size(); ++k) {
        cv::solvePnPRefineLM(objects, images, K, D, rotations[k], translations[k]);
        LensPose pose;
        pose.guess.X_SC =
            Eigen::Translation3d(cloud.mean) * PoseOf(rotations[k], translations[k]).inverse();
        for (const std::size_t i : which) {
          const double miss = LensMiss(lens, pose.guess.X_SC, places[i]);
          pose.sum_of_squares += std::isfinite(miss) ? miss * miss : HUGE_VAL;
        }
        poses.push_back(pose);
      }
    } catch (const std::exception&) {  // cv::Exception or no finite pose: the method has none
    }
  }
  std::ranges::sort(poses, {}, &LensPose::sum_of_squares);
  return poses;
}

}  // namespace palpate
