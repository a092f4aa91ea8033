#include "slave/vision/calibration/registration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <fmt/format.h>
#include <opencv2/calib3d.hpp>

#include "shared/geometry/rotation_between.h"
#include "slave/vision/calibration/lens_calibration.h"
#include "slave/vision/calibration/robust_fit.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {
namespace {

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

// The pictures' noise is the same in all of them.
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

// Of the places used, were the table their mirror image.
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

// Places about their middle: from afar, turns and shifts of the camera are hard to tell apart.
struct PnpProblem {
  std::vector<cv::Point3d> objects;
  std::vector<cv::Point2d> pictures;
  cv::Matx33d K;
  cv::Mat D;
};

PnpProblem ProblemOf(const Lens& lens, const std::vector<TipPlace>& places, const Indices& which,
                     const Eigen::Vector3d& middle_S) {
  PnpProblem problem{{}, {}, CameraMatrixOf(lens), DistortionOf(lens)};
  for (const std::size_t i : which) {
    const TipPlace& at = places[i];
    const Eigen::Vector3d p = at.p_S - middle_S;
    problem.objects.emplace_back(p.x(), p.y(), p.z());
    problem.pictures.emplace_back(at.left_I.x(), at.left_I.y());
  }
  return problem;
}

// X_CS, S about the places' middle, with the places' plane tilted to the other side of the line of
// sight.
Eigen::Isometry3d TurnedOver(const Eigen::Isometry3d& X_CS, const Eigen::Vector3d& normal_S) {
  const Eigen::Vector3d middle_C = X_CS.translation(), sight = middle_C.normalized();
  const Eigen::Vector3d normal_C = X_CS.linear() * normal_S;
  const Eigen::Vector3d other_C = 2 * sight.dot(normal_C) * sight - normal_C;
  Eigen::Isometry3d out = X_CS;
  out.linear() = RotationBetween(normal_C, other_C) * X_CS.linear();
  return out;
}

// Accepted: places at least this wide across their longest direction, at most this uncertain, and
// no more outliers than half of what fits.
constexpr double kWidth = 0.05, kAngle = 2 * std::numbers::pi / 180, kScatter = 0.05;
constexpr double kUsed = 2.0 / 3;
// Two fits of the same places are alike where their misses differ by less than this factor.
constexpr double kAlike = 2;

}  // namespace

CameraRegistration RegisterPair(const StereoRig& rig, const std::vector<TipPlace>& places) {
  constexpr std::size_t kFewest = 3;
  const SeenTips seen = Triangulate(rig, places);
  const auto solve = [&](const std::vector<TipPlace>& table, const Indices& which) {
    return Kabsch(seen.p_L, table, which);
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

double LensMiss(const Lens& lens, const Eigen::Isometry3d& X_SC, const TipPlace& place) {
  const auto at = Project(lens, X_SC.inverse() * place.p_S);
  return at ? (*at - place.left_I).norm() : std::numeric_limits<double>::quiet_NaN();
}

std::vector<LensPose> LensPoses(const Lens& lens, const std::vector<TipPlace>& places,
                                const Indices& which) {
  std::vector<LensPose> poses;
  const PlaceCloud cloud = CloudOf(which, places);
  const PnpProblem problem = ProblemOf(lens, places, which, cloud.mean);
  const auto keep = [&](cv::Mat rotation, cv::Mat translation) {
    cv::solvePnPRefineLM(problem.objects, problem.pictures, problem.K, problem.D, rotation,
                         translation);
    const Eigen::Isometry3d X_SC =
        Eigen::Translation3d(cloud.mean) * PoseOf(rotation, translation).inverse();
    LensPose pose{{X_SC, 0}, 0};
    for (const std::size_t i : which) {
      const double miss = LensMiss(lens, pose.guess.X_SC, places[i]);
      pose.sum_of_squares += std::isfinite(miss) ? miss * miss : HUGE_VAL;
    }
    poses.push_back(pose);
  };
  try {
    cv::Mat rotation, translation;
    if (!cv::solvePnP(problem.objects, problem.pictures, problem.K, problem.D, rotation,
                      translation, false, cv::SOLVEPNP_SQPNP)) {
      return poses;
    }
    const Eigen::Isometry3d other_CS = TurnedOver(PoseOf(rotation, translation), cloud.normal);
    keep(rotation, translation);
    const Eigen::AngleAxisd turn(other_CS.linear());
    const Eigen::Vector3d r = turn.angle() * turn.axis(), t = other_CS.translation();
    keep(cv::Mat(cv::Vec3d(r.x(), r.y(), r.z())), cv::Mat(cv::Vec3d(t.x(), t.y(), t.z())));
  } catch (const std::exception&) {  // cv::Exception or no finite pose: what there is, is kept
  }
  if (poses.size() == 2 && poses[1].sum_of_squares < poses[0].sum_of_squares) {
    std::swap(poses[0], poses[1]);
  }
  return poses;
}

Indices UsedOf(const CameraRegistration& r) {
  Indices used;
  for (std::size_t i = 0; i < r.used.size(); ++i) {
    if (r.used[i]) used.push_back(i);
  }
  return used;
}

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

void CheckPlaces(const Eigen::Vector3d& extents, std::size_t fewest, CameraRegistration* r) {
  const std::size_t used = UsedOf(*r).size();
  if (used <= fewest) {
    r->reasons.push_back(fmt::format("{} positions are too few to check the result: accepted is {}",
                                     used, fewest + 1));
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

void CheckMirror(double mirrored_rms, const std::vector<TipPlace>& places, CameraRegistration* r) {
  const PlaceCloud cloud = CloudOf(UsedOf(*r), places);
  if (!(cloud.extents[1] > kWidth * cloud.extents[2])) return;  // on a line: told already
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

void CheckScatter(double rms_m, const Eigen::Vector3d& extents, CameraRegistration* r) {
  if (!(r->sigma_angle <= kAngle)) {
    r->reasons.push_back(
        fmt::format("the camera's direction has a sigma of {:.2g} deg: accepted is {:.2g}; use "
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

Indices AllIndices(std::size_t count) {
  Indices all(count);
  for (std::size_t i = 0; i < count; ++i) all[i] = i;
  return all;
}

void RefuseTooFew(std::size_t usable, std::size_t fewest) {
  throw std::runtime_error(
      fmt::format("usable positions: {}; they do not determine a camera pose: accepted is {} or "
                  "more that are not collinear",
                  usable, fewest + 1));
}

void CheckHeights(const Indices& used, const std::vector<TipPlace>& places,
                  const Eigen::Vector3d& extents, CameraRegistration* r) {
  double highest = 0;
  for (const std::size_t i : used) highest = std::max(highest, std::abs(places[i].p_S.z()));
  if (highest <= kScatter * extents[2]) return;
  r->reasons.push_back(
      fmt::format("a position is {:.3g} mm off the plane z = 0 of S", 1e3 * highest));
}

}  // namespace palpate
