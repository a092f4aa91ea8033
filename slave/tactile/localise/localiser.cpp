#include "slave/tactile/localise/localiser.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>

#include "slave/tactile/localise/direction_mean.h"

namespace palpate {
namespace {

// 68 % of the presses on a plate are nearer to the measured normal (contact_direction_test.cpp).
// [rad] [tuned: SigmaHoldsTwoThirdsOfThePlaces]
constexpr double kSigmaAngle = 10.5 * std::numbers::pi / 180;

// Angle within which 68 % of the presses on a plate are (contact_direction_test.cpp): it decreases
// with the sum of the intensities as the noise of a mean does.
constexpr double kDegree = std::numbers::pi / 180;  // [rad] [by definition]
constexpr double kSigmaOfOneCount = 200 * kDegree;  // [rad] [tuned: SigmaHoldsTwoThirdsOfThePlaces]
constexpr double kMinSigma = 4 * kDegree;           // [rad] [tuned: SigmaHoldsTwoThirdsOfThePlaces]
constexpr double kMaxSigma = 30 * kDegree;

double PressureWeightedSigma(double counts) noexcept {
  return std::clamp(kSigmaOfOneCount / std::sqrt(counts), kMinSigma, kMaxSigma);
}

// Change of full intensity [counts]. [paper: B, III.A.2]
constexpr double kFullScale = 200;

// Paper B, equations (1) to (4), as the paper and its authors' code compute them. Electrodes that
// fell by more than the threshold are active. The intensity is their fall divided by the full
// scale, at most 1. The result is also flawed if all of several active electrodes are beyond full
// scale, because their intensities give no information.
class PaperLocaliser final : public Localiser {
 public:
  PaperLocaliser(const Tactile& tactile, const ElectrodeLayout& layout)
      : layout_(layout),
        surface_{tactile.finger_radius},
        check_(layout, tactile.threshold),
        threshold_(tactile.threshold) {}

  [[nodiscard]] TouchPlace Locate(const TactileSignals& change,
                                  const FingerReading& raw) const noexcept override {
    const SignalFlaws flaws = check_.Check(change, raw);
    if (!flaws.finite) return NoPlace(TouchPlace::Status::kFailed);
    std::array<Eigen::Vector3d, kElectrodeCount> p_F;
    std::array<double, kElectrodeCount> intensity{};
    std::size_t active = 0, clipped = 0;
    for (std::size_t i = 0; i < kElectrodeCount; ++i) {
      const double fall = -static_cast<double>(change[i]);
      if (!(fall > threshold_)) continue;
      clipped += fall >= kFullScale ? 1 : 0;
      p_F[active] = layout_.p_F[i];
      intensity[active] = std::min(fall / kFullScale, 1.0);
      ++active;
    }
    const auto point =
        ContactPointOf(std::span(p_F.data(), active), std::span(intensity.data(), active));
    if (!point) return NoPlace(TouchPlace::Status::kNoContact, flaws.any());
    const auto place_F = surface_.Project(point->c);
    if (!place_F) return NoPlace(TouchPlace::Status::kAtOrigin, flaws.any());
    const bool is_flawed = flaws.any() || (active > 1 && clipped == active);
    return FoundPlace(surface_, *place_F, kSigmaAngle, is_flawed, static_cast<int>(active));
  }
  [[nodiscard]] std::string_view name() const override { return "paper"; }

 private:
  ElectrodeLayout layout_;
  FingerSurface surface_;
  SignalCheck check_;
  double threshold_;  // [counts]
};

// DirectionMean with the intensities of PressureWeighted.
class PressureWeightedLocaliser final : public Localiser {
 public:
  PressureWeightedLocaliser(const Tactile& tactile, const ElectrodeLayout& layout)
      : mean_(layout, tactile.finger_radius),
        check_(layout, tactile.threshold),
        threshold_(tactile.threshold) {}

  [[nodiscard]] TouchPlace Locate(const TactileSignals& change,
                                  const FingerReading& raw) const noexcept override {
    const SignalFlaws flaws = check_.Check(change, raw);
    if (!flaws.finite) return NoPlace(TouchPlace::Status::kFailed);
    const Intensities intensities = PressureWeighted(change, flaws, threshold_);
    if (intensities.active == 0) return NoPlace(TouchPlace::Status::kNoContact, flaws.any());
    const auto direction = mean_.Mean(intensities);
    if (!direction) return NoPlace(TouchPlace::Status::kAtOrigin, flaws.any());
    return FoundPlace(mean_.surface(), mean_.PlaceOf(*direction),
                      PressureWeightedSigma(intensities.total), flaws.any(), intensities.active);
  }
  [[nodiscard]] std::string_view name() const override { return "pressure-weighted"; }

 private:
  DirectionMean mean_;
  SignalCheck check_;
  double threshold_;  // [counts]
};

class ChannelLocaliser final : public Localiser {
 public:
  ChannelLocaliser(double threshold, const ElectrodeLayout& layout)
      : layout_(layout), threshold_(threshold) {}

  [[nodiscard]] TouchPlace Locate(const TactileSignals& change,
                                  const FingerReading& /*raw*/) const noexcept override {
    TouchPlace place;
    double total = 0;
    for (std::size_t i = 0; i < layout_.p_F.size(); ++i) {
      const double size = std::abs(change[i]);
      if (!std::isfinite(size)) return NoPlace(TouchPlace::Status::kFailed);
      if (size <= threshold_) continue;
      place.p_F += size * layout_.p_F[i];
      place.n_F += size * layout_.n_F[i];
      total += size;
      ++place.active;
    }
    if (place.active == 0) return NoPlace(TouchPlace::Status::kNoContact);
    if (!(place.n_F.norm() > kCancelled * total)) return NoPlace(TouchPlace::Status::kAtOrigin);
    place.status = TouchPlace::Status::kFound;
    place.p_F /= total;
    place.n_F.normalize();
    return place;
  }
  [[nodiscard]] std::string_view name() const override { return "mean of the active channels"; }

 private:
  static constexpr double kCancelled = 1e-6;  // of the normals
  ElectrodeLayout layout_;
  double threshold_;  // [unit of the channels]
};

}  // namespace

std::optional<ContactPoint> ContactPointOf(std::span<const Eigen::Vector3d> p,
                                           std::span<const double> intensity) noexcept {
  assert(p.size() == intensity.size());
  ContactPoint point;
  double total = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    point.centroid += p[i];
    total += intensity[i];
  }
  if (!(total > 0)) return std::nullopt;
  const auto m = static_cast<double>(p.size());
  point.centroid /= m;
  Eigen::Vector3d d(0, 0, 0);
  for (std::size_t i = 0; i < p.size(); ++i) {
    d += intensity[i] / total * (p[i] - point.centroid);
  }
  point.c = point.centroid + d / m;
  if (!point.c.allFinite()) return std::nullopt;
  return point;
}

std::unique_ptr<Localiser> MakeChannelLocaliser(const Tactile& tactile, double noise,
                                                const ElectrodeLayout& layout) {
  return std::make_unique<ChannelLocaliser>(tactile.threshold * noise, layout);
}

std::unique_ptr<Localiser> MakeLocaliser(const Tactile& tactile, const ElectrodeLayout& layout) {
  const std::string& name = tactile.localise;
  if (name == "paper") return std::make_unique<PaperLocaliser>(tactile, layout);
  if (name == "auto" || name == "pressure-weighted") {
    return std::make_unique<PressureWeightedLocaliser>(tactile, layout);
  }
  throw std::invalid_argument("localise = " + name + ": expected auto, paper or pressure-weighted");
}

}  // namespace palpate
