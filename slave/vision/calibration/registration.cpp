#include "slave/vision/calibration/registration.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <utility>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <opencv2/calib3d.hpp>

#include "slave/statistics/robust.h"
#include "slave/vision/calibration/calibration.h"

namespace palpate {
namespace {

// Limits for acceptance: smallest width of the positions across their longest direction, largest
// uncertainty, and outliers at most half as many as inliers.
constexpr double kWidth = 0.05, kAngle = 2 * std::numbers::pi / 180, kScatter = 0.05;
constexpr double kUsedPositions = 2.0 / 3;

using Indices = std::vector<std::size_t>;
using Points = std::vector<Eigen::Vector3d>;

struct Guess {
  Eigen::Isometry3d X_SC = Eigen::Isometry3d::Identity();
  double pixel = 0;  // [m]
};

// A method to compute the camera pose, with its image points.
struct Way {
  std::size_t fewest = 0;  // positions that determine a pose
  Indices usable;          // positions that have a ray, or an intersection
  // Least-squares poses from the positions `which`, the best first; empty: none.
  std::function<std::vector<Guess>(const Points& p_S, const Indices& which)> solve;
  // Residual of position `i` [m]; NaN: unknown.
  std::function<double(const Guess& guess, const Eigen::Vector3d& p_S, std::size_t i)> miss;
};

double RmsOf(const Way& way, const Guess& guess, const Points& p_S, const Indices& which) {
  double sum = 0;
  for (const std::size_t i : which) {
    const double miss = way.miss(guess, p_S[i], i);
    sum += std::isfinite(miss) ? miss * miss : HUGE_VAL;
  }
  return std::sqrt(sum / static_cast<double>(which.size()));
}

// Least median of squares over random subsets (fixed seed), then those within three robust sigma
// (Rousseeuw and Leroy, Robust Regression and Outlier Detection, 1987, ch. 5). All of them where
// too few are usable to detect an outlier.
Indices AgreeingPlaces(const Way& way, const Points& p_S) {
  constexpr int kSubsets = 400;
  const std::size_t count = way.usable.size();
  if (count < way.fewest + 2) return way.usable;
  // Points that the subset fits exactly do not count as agreement.
  const std::size_t rank = std::min((count + way.fewest + 1) / 2, count - 1);
  const double factor = 3 * kSigmaPerMedian * (1 + 5 / static_cast<double>(count - way.fewest));
  Indices best;
  double least = HUGE_VAL;
  std::mt19937 random(1987);
  for (int k = 0; k < kSubsets; ++k) {
    Indices subset = way.usable;
    for (std::size_t i = 0; i < way.fewest; ++i) {
      std::swap(subset[i], subset[i + random() % (count - i)]);
    }
    subset.resize(way.fewest);
    const std::vector<Guess> guesses = way.solve(p_S, subset);
    if (guesses.empty()) continue;
    std::vector<std::pair<double, std::size_t>> misses;
    for (const std::size_t i : way.usable) {
      const double miss = way.miss(guesses.front(), p_S[i], i);
      misses.emplace_back(std::isfinite(miss) ? miss : HUGE_VAL, i);
    }
    std::ranges::sort(misses);
    if (misses[rank].first >= least) continue;
    least = misses[rank].first;
    best.clear();
    for (const auto& [miss, i] : misses) {
      if (miss <= factor * least + 1e-12) best.push_back(i);
    }
  }
  std::ranges::sort(best);
  return best;
}

double LargestSigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[2]));
}

// Computes sigmas by the jackknife: from the poses found without one position each.
void SetSigmas(const Way& way, const Points& p_S, const Indices& used, CameraRegistration* r) {
  r->sigma_angle = r->sigma_place = HUGE_VAL;
  if (used.size() <= way.fewest) return;
  Eigen::Matrix3d angle = Eigen::Matrix3d::Zero(), place = Eigen::Matrix3d::Zero();
  for (const std::size_t left_out : used) {
    Indices rest = used;
    std::erase(rest, left_out);
    const std::vector<Guess> guesses = way.solve(p_S, rest);
    if (guesses.empty()) return;
    const Eigen::Isometry3d& X_SC = guesses.front().X_SC;
    const Eigen::AngleAxisd turn(r->X_SC.linear().transpose() * X_SC.linear());
    const Eigen::Vector3d shift = X_SC.translation() - r->X_SC.translation();
    angle += turn.angle() * turn.angle() * turn.axis() * turn.axis().transpose();
    place += shift * shift.transpose();
  }
  const auto count = static_cast<double>(used.size());
  r->sigma_angle = LargestSigma((count - 1) / count * angle);
  r->sigma_place = LargestSigma((count - 1) / count * place);
}

// Positions and their principal directions.
struct PlaceCloud {
  Eigen::Vector3d mean{0, 0, 0};
  Eigen::Vector3d extents{0, 0, 0};  // root mean square along the directions, rising [m]
  Eigen::Vector3d normal{0, 0, 1};   // the direction of the smallest extent
};

PlaceCloud CloudOf(const Points& p_S, const Indices& used) {
  PlaceCloud cloud;
  for (const std::size_t i : used) cloud.mean += p_S[i] / static_cast<double>(used.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const std::size_t i : used) {
    const Eigen::Vector3d d = p_S[i] - cloud.mean;
    scatter += d * d.transpose() / static_cast<double>(used.size());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  cloud.extents = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  cloud.normal = solver.eigenvectors().col(0);
  return cloud;
}

// Coplanar positions fit as well mirrored, with the camera on the other side of their plane.
std::string SideWords(const PlaceCloud& cloud, const Eigen::Isometry3d& X_SC) {
  int axis = 0;  // of S, the one the plane faces most
  cloud.normal.cwiseAbs().maxCoeff(&axis);
  const double distance = (X_SC.translation() - cloud.mean).dot(cloud.normal);
  const bool is_greater = distance * cloud.normal[axis] > 0;
  return fmt::format(
      "the positions are coplanar: a table with a wrong sign or exchanged columns fits as well, "
      "with the camera on the other side. Check that the camera is {:.3g} mm from the plane, on "
      "the side where {} of S is {}, and looks towards {}{}",
      1e3 * std::abs(distance), "xyz"[axis], is_greater ? "greater" : "smaller",
      is_greater ? '-' : '+', "xyz"[axis]);
}

// `mirrored_rms`: residual of the used positions for the mirrored table [m].
void CheckMirror(const PlaceCloud& cloud, double mirrored_rms, CameraRegistration* r) {
  // Two fits are equivalent if their residuals differ by less than this factor.
  constexpr double kAlike = 2, kExact = 1e-12;  // [m]: both fit without any residual
  if (kAlike * mirrored_rms + kExact < r->rms) {
    r->reasons.push_back(
        "the positions are a mirror image of the image points: the sign of a column x, y or z is "
        "wrong, or two columns are exchanged");
  } else if (mirrored_rms <= kAlike * r->rms + kExact) {
    r->warnings.push_back(SideWords(cloud, r->X_SC));
  }
}

void CheckPlaces(const PlaceCloud& cloud, std::size_t used, std::size_t fewest,
                 CameraRegistration* r) {
  if (used <= fewest) {
    r->reasons.push_back(
        fmt::format("{} positions are too few to check the result: expected {}", used, fewest + 1));
  }
  if (static_cast<double>(used) < kUsedPositions * static_cast<double>(r->used.size())) {
    r->reasons.push_back(
        fmt::format("only {} of {} positions agree with each other", used, r->used.size()));
  }
  if (!(r->sigma_angle <= kAngle)) {
    r->reasons.push_back(
        fmt::format("the camera's direction has a sigma of {:.2g} deg: expected {:.2g}; use "
                    "positions that are farther apart",
                    r->sigma_angle * 180 / std::numbers::pi, kAngle * 180 / std::numbers::pi));
  }
  if (!(r->rms <= kScatter * cloud.extents[2])) {
    r->reasons.push_back(
        fmt::format("the residual of the positions is {:.3g} mm rms, more than {:.0f} % of their "
                    "spread of {:.3g} mm",
                    1e3 * r->rms, 100 * kScatter, 1e3 * cloud.extents[2]));
  }
}

// Checks whether positions on a plane fit a second pose with opposite tilt, as for a distant
// camera.
void CheckOtherPose(const Way& way, const Points& p_S, const Indices& used, CameraRegistration* r) {
  const std::vector<Guess> guesses = way.solve(p_S, used);
  const double spare = std::max(2.0 * static_cast<double>(used.size()) - 6, 1.0);
  for (const Guess& other : guesses) {
    const double angle =
        Eigen::AngleAxisd(r->X_SC.linear().transpose() * other.X_SC.linear()).angle();
    constexpr double kSame = 1e-3;  // [rad]: smaller differences are the same minimum
    const double rms = RmsOf(way, other, p_S, used);
    // Accepted if the residual of the other pose is larger by three sigma.
    if (angle < kSame || rms > r->rms * std::sqrt(1 + 9 / spare) + 1e-12) continue;
    r->reasons.push_back(
        fmt::format("a second pose, rotated by {:.3g} deg, fits nearly as well ({:.3g} mm rms): "
                    "use positions that are not coplanar, or nearer to the camera",
                    angle * 180 / std::numbers::pi, 1e3 * rms));
    return;
  }
}

CameraRegistration Register(const Way& way, const std::vector<TipPlace>& places) {
  Points p_S;
  for (const TipPlace& place : places) p_S.push_back(place.p_S);
  const Indices used = AgreeingPlaces(way, p_S);
  const std::vector<Guess> guesses =
      used.size() < way.fewest ? std::vector<Guess>() : way.solve(p_S, used);
  if (guesses.empty()) {
    throw std::runtime_error(
        fmt::format("usable positions: {}; they do not determine a camera pose: expected {} or "
                    "more that are not collinear",
                    way.usable.size(), way.fewest + 1));
  }
  CameraRegistration out;
  out.X_SC = guesses.front().X_SC;
  out.pixel = guesses.front().pixel;
  out.residuals.resize(places.size(), std::numeric_limits<double>::quiet_NaN());
  out.used.resize(places.size(), false);
  for (const std::size_t i : way.usable) out.residuals[i] = way.miss(guesses.front(), p_S[i], i);
  for (const std::size_t i : used) out.used[i] = true;
  out.rms = RmsOf(way, guesses.front(), p_S, used);
  SetSigmas(way, p_S, used, &out);
  const PlaceCloud cloud = CloudOf(p_S, used);
  CheckPlaces(cloud, used.size(), way.fewest, &out);
  if (cloud.extents[1] > kWidth * cloud.extents[2]) {
    Points mirrored = p_S;
    for (Eigen::Vector3d& p : mirrored) p.x() *= -1;
    const std::vector<Guess> others = way.solve(mirrored, used);
    if (!others.empty()) CheckMirror(cloud, RmsOf(way, others.front(), mirrored, used), &out);
  } else {
    out.reasons.push_back(
        "the positions are collinear: the rotation about the line is not determined, and a mirror "
        "image is not detected");
  }
  if (guesses.size() > 1) CheckOtherPose(way, p_S, used, &out);
  return out;
}

// Returns local minima of the residual: from OpenCV's SQPnP, and for a plane from IPPE, which
// returns both similar poses; each is refined.
std::vector<Guess> LensPoses(const Lens& lens, const std::vector<TipPlace>& places,
                             const Points& p_S, const Indices& which) {
  // Computes about the mean of the positions, because far from the origin rotation and translation
  // are strongly correlated.
  const Eigen::Vector3d mean = CloudOf(p_S, which).mean;
  std::vector<cv::Point3d> objects;
  std::vector<cv::Point2d> images;
  for (const std::size_t i : which) {
    const Eigen::Vector3d p = p_S[i] - mean;
    objects.emplace_back(p.x(), p.y(), p.z());
    images.emplace_back(places[i].left_I.x(), places[i].left_I.y());
  }
  const cv::Matx33d K = CameraMatrixOf(lens);
  const cv::Mat D = DistortionOf(lens);
  std::vector<Guess> poses;
  for (const cv::SolvePnPMethod method : {cv::SOLVEPNP_SQPNP, cv::SOLVEPNP_IPPE}) {
    try {
      std::vector<cv::Mat> rotations, translations;
      cv::solvePnPGeneric(objects, images, K, D, rotations, translations, false, method);
      for (std::size_t k = 0; k < rotations.size(); ++k) {
        cv::solvePnPRefineLM(objects, images, K, D, rotations[k], translations[k]);
        const Eigen::Isometry3d X_CS = PoseOf(rotations[k], translations[k]);
        poses.push_back({Eigen::Translation3d(mean) * X_CS.inverse(), 0});
      }
    } catch (const std::exception&) {  // no plane, or no finite pose: the method has none
    }
  }
  return poses;
}

}  // namespace

CameraRegistration RegisterPair(const StereoRig& rig, const std::vector<TipPlace>& places) {
  Way way{.fewest = 3};
  Points p_L(places.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!places[i].right_I) continue;
    const auto point = Triangulate(rig, places[i].left_I, *places[i].right_I, 1);
    if (!point) continue;
    p_L[i] = point->p_L;
    way.usable.push_back(i);
  }
  way.solve = [&](const Points& p_S, const Indices& which) -> std::vector<Guess> {
    Eigen::Matrix3Xd from(3, which.size()), to(3, which.size());
    for (Eigen::Index k = 0; k < from.cols(); ++k) {
      from.col(k) = p_L[which[static_cast<std::size_t>(k)]];
      to.col(k) = p_S[which[static_cast<std::size_t>(k)]];
    }
    return {{Eigen::Isometry3d(Eigen::umeyama(from, to, false)), 0}};
  };
  way.miss = [&](const Guess& guess, const Eigen::Vector3d& p_S, std::size_t i) {
    return (guess.X_SC * p_L[i] - p_S).norm();
  };
  return Register(way, places);
}

CameraRegistration RegisterLens(const Lens& lens, const std::vector<TipPlace>& places) {
  Way way{.fewest = 4};
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (RayOf(lens, places[i].left_I)) way.usable.push_back(i);
  }
  way.miss = [&](const Guess& guess, const Eigen::Vector3d& p_S, std::size_t i) {
    const Eigen::Vector3d p_C = guess.X_SC.inverse() * p_S;
    const auto at = Project(lens, p_C);
    return at ? (*at - places[i].left_I).norm() * p_C.z() / std::sqrt(lens.fx * lens.fy)
              : std::numeric_limits<double>::quiet_NaN();
  };
  way.solve = [&](const Points& p_S, const Indices& which) {
    std::vector<Guess> poses = LensPoses(lens, places, p_S, which);
    std::ranges::sort(poses, {}, [&](const Guess& g) { return RmsOf(way, g, p_S, which); });
    return poses;
  };
  return Register(way, places);
}

CameraRegistration RegisterPlane(const std::array<int, 2>& size,
                                 const std::vector<TipPlace>& places) {
  Way way{.fewest = 2};
  for (std::size_t i = 0; i < places.size(); ++i) way.usable.push_back(i);
  const auto from_centre_px = [&](std::size_t i) {
    const Eigen::Vector2d& p_I = places[i].left_I;
    return Eigen::Vector2d(p_I.x() - 0.5 * (size[0] - 1), 0.5 * (size[1] - 1) - p_I.y());
  };
  way.solve = [&](const Points& p_S, const Indices& which) -> std::vector<Guess> {
    Eigen::Matrix2Xd from(2, which.size()), to(2, which.size());
    for (Eigen::Index k = 0; k < from.cols(); ++k) {
      from.col(k) = from_centre_px(which[static_cast<std::size_t>(k)]);
      to.col(k) = p_S[which[static_cast<std::size_t>(k)]].head<2>();
    }
    const Eigen::Matrix3d X = Eigen::umeyama(from, to, true);
    Guess guess;
    guess.pixel = X.block<2, 1>(0, 0).norm();
    if (!(guess.pixel > 0) || !X.allFinite()) return {};
    guess.X_SC.linear().topLeftCorner<2, 2>() = X.topLeftCorner<2, 2>() / guess.pixel;
    guess.X_SC.translation().head<2>() = X.topRightCorner<2, 1>();
    return {guess};
  };
  way.miss = [&](const Guess& guess, const Eigen::Vector3d& p_S, std::size_t i) {
    Eigen::Vector3d p_C(0, 0, 0);
    p_C.head<2>() = guess.pixel * from_centre_px(i);
    return (guess.X_SC * p_C - p_S).head<2>().norm();
  };
  CameraRegistration out = Register(way, places);
  // A position above the plane has the image of another point of the plane.
  double highest = 0;
  Points p_S;
  Indices used;
  for (std::size_t i = 0; i < places.size(); ++i) {
    p_S.push_back(places[i].p_S);
    if (!out.used[i]) continue;
    used.push_back(i);
    highest = std::max(highest, std::abs(places[i].p_S.z()));
  }
  if (highest > kScatter * CloudOf(p_S, used).extents[2]) {
    out.reasons.push_back(
        fmt::format("a position is {:.3g} mm off the plane z = 0 of S", 1e3 * highest));
  }
  return out;
}

}  // namespace palpate
