#include "slave/pipeline/local_model/force_law.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

// Variance of positions below which a slope gives no information [m^2].
constexpr double kVariance = 1e-8;
constexpr double kSoftestObject = 300;    // stiffness before any estimate [N/m]
constexpr double kStiffestObject = 5000;  // [N/m]
constexpr double kMinForce = 1e-9;        // [N]

}  // namespace

ForceLaw::ForceLaw(double depth, double period)
    : depth_(depth),
      spacing_(depth / (kLawPoints - 1)),
      forget_(std::exp(-period / kMemory)),
      forget_line_(std::exp(-period / kLineMemory)) {}

double ForceLaw::Line::slope() const noexcept {
  if (!(n > 0)) return kSoftestObject;
  const double spread = std::max(0.0, xx / n - x * x / n / n);
  const double covariance = xf / n - x * f / n / n;
  return std::clamp((covariance + kSoftestObject * kVariance) / (spread + kVariance),
                    kSoftestObject, kStiffestObject);
}

void ForceLaw::AddSample(const Eigen::Vector3d& p_S, const Eigen::Vector3d& force_S,
                         double sigma) noexcept {
  const double size = force_S.norm();
  if (!p_S.allFinite() || !std::isfinite(size)) return;
  for (Place& place : places_) {
    place.weight *= forget_;
    place.force *= forget_;
  }
  const bool presses = size > std::max(kTouch * sigma, kMinForce);
  if (!begun_) {
    if (!presses) return;
    begun_ = true;
    n_ = force_S / size;
    origin_ = p_S;
  }
  const double x = PlaceOf(p_S), f = n_.dot(force_S);
  if (presses) {
    line_ = {forget_line_ * line_.n + 1, forget_line_ * line_.x + x, forget_line_ * line_.f + f,
             forget_line_ * line_.xx + x * x, forget_line_ * line_.xf + x * f};
  }
  const double at = x / spacing_ + kPlaces / 2.0;
  if (!(at >= 0 && at < kPlaces - 1)) return;
  const int below = static_cast<int>(at);
  for (const int k : {0, 1}) {
    const double weight = k == 0 ? 1 - (at - below) : at - below;
    Place& place = places_[static_cast<std::size_t>(below + k)];
    place.weight += weight;
    place.force += weight * f;
  }
}

double ForceLaw::ByLine(double x) const noexcept {
  if (!(line_.n > 0)) return 0;
  return std::max(0.0, line_.f / line_.n + line_.slope() * (x - line_.x / line_.n));
}

double ForceLaw::ValueOf(int place) const noexcept {
  const double line = ByLine((place - kPlaces / 2) * spacing_);
  if (place < 0 || place >= kPlaces) return line;
  const Place& estimate = places_[static_cast<std::size_t>(place)];
  return std::max(0.0, (estimate.force + kPrior * line) / (estimate.weight + kPrior));
}

double ForceLaw::AtPlace(double x) const noexcept {
  const double at = x / spacing_ + kPlaces / 2.0;
  const int below = static_cast<int>(std::floor(at));
  const double low = ValueOf(below);
  return low + (at - below) * (ValueOf(below + 1) - low);
}

// Searches outwards from the middle of the pressed range for the position at which the force ends.
double ForceLaw::Surface() const noexcept {
  const int middle = static_cast<int>(std::lround(line_.x / line_.n / spacing_)) + kPlaces / 2;
  for (int place = middle; place > middle - kPlaces; --place) {
    if (ValueOf(place) < kMinForce) return (place - kPlaces / 2) * spacing_;
  }
  return line_.x / line_.n - depth_;
}

void ForceLaw::Export(SurfacePatch* patch, PatchLaw* law) const noexcept {
  const double surface = Surface(), K = line_.slope();
  *patch = SurfacePatch();
  patch->vertices_per_cell = 1;
  patch->vertex_count = patch->node_count = 1;
  patch->vertices[0] = (origin_ - surface * n_).cast<float>();
  patch->normal = n_;
  patch->directions = 1;
  patch->compliance.setConstant(1, 1, static_cast<float>(1 / K));
  patch->full_depth = patch->valid_depth = depth_;
  for (int i = 1; i < kLawPoints; ++i) {
    const double depth = i * spacing_;
    law->ratios[static_cast<std::size_t>(i)] = AtPlace(surface + depth) / (K * depth);
  }
  law->ratios[0] = law->ratios[1];
}

}  // namespace palpate
