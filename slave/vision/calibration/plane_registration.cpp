// A camera straight above the plane z = 0 of S.
#include <cmath>
#include <complex>
#include <stdexcept>

#include <fmt/format.h>

#include "slave/vision/calibration/registration.h"
#include "slave/vision/stereo/lens_warp.h"

namespace palpate {
namespace {

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
      places.size(), AllIndices(places.size()), 2,
      [&](const Indices& which) { return SolvePlane(size, places, which, mirror); }, miss);
}

}  // namespace

CameraRegistration RegisterPlane(const std::array<int, 2>& size,
                                 const std::vector<TipPlace>& places) {
  constexpr std::size_t kFewest = 2;
  const auto fit = places.size() < kFewest ? std::nullopt : FitPlane(size, places, 1);
  if (!fit) RefuseTooFew(places.size(), kFewest);
  CameraRegistration out = RegistrationOf(*fit, false);
  const Indices used = UsedOf(out);
  const Eigen::Vector3d extents = CloudOf(used, places).extents;
  const double across = std::hypot(extents[1], extents[2]);
  out.sigma_angle =
      across > 0 ? out.rms / std::sqrt(2.0) / (across * std::sqrt(static_cast<double>(used.size())))
                 : HUGE_VAL;
  if (const auto mirrored = FitPlane(size, places, -1)) {
    if (RegistrationOf(*mirrored, false).rms < 0.3 * out.rms && used.size() > kFewest) {
      out.reasons.emplace_back(
          "the image is a mirror image of S: accepted is a camera that looks along -z of S");
    }
  }
  CheckPlaces(extents, kFewest, &out);
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
          "row {}: u, v = {:g}, {:g}: accepted is a pixel of the lens's image, {} x {}", i + 1,
          places[i].left_I.x(), places[i].left_I.y(), lens.size[0], lens.size[1]));
    }
    straight[i].left_I = *at;
  }
  return RegisterPlane(lens.size, straight);
}

}  // namespace palpate
