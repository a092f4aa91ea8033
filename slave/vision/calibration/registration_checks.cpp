#include "slave/vision/calibration/registration_checks.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

namespace palpate {
namespace {

// Accepted: places at least this wide across their longest direction, at most this uncertain, and
// no more outliers than half of what fits.
constexpr double kWidth = 0.05, kAngle = 2 * std::numbers::pi / 180, kScatter = 0.05;
constexpr double kUsed = 2.0 / 3;
// Two fits of the same places are alike where their misses differ by less than this factor.
constexpr double kAlike = 2;

}  // namespace

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
