#include "slave/tactile/localise/paper_localiser.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numbers>
#include <span>

#include "slave/tactile/localise/contact_point.h"
#include "slave/tactile/localise/found_place.h"

namespace palpate {
namespace {

// 68 % of the presses on a plate are nearer to the measured normal (contact_direction_test.cpp).
constexpr double kSigmaAngle = 10.5 * std::numbers::pi / 180;

}  // namespace

PaperLocaliser::PaperLocaliser(const Tactile& tactile, const ElectrodeLayout& layout)
    : layout_(layout),
      surface_{tactile.finger_radius},
      check_(layout, tactile.threshold),
      threshold_(tactile.threshold),
      full_scale_(tactile.full_scale) {}

TouchPlace PaperLocaliser::Locate(const TactileSignals& change,
                                  const FingerReading& raw) const noexcept {
  const SignalFlaws flaws = check_.Check(change, raw);
  if (!flaws.finite) return NoPlace(TouchPlace::Status::kFailed);
  std::array<Eigen::Vector3d, kElectrodeCount> p_F;
  std::array<double, kElectrodeCount> intensity{};
  std::size_t active = 0, clipped = 0;
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    const double fall = -static_cast<double>(change[i]);
    if (!(fall > threshold_)) continue;
    clipped += fall >= full_scale_ ? 1 : 0;
    p_F[active] = layout_.p_F[i];
    intensity[active] = std::min(fall / full_scale_, 1.0);
    ++active;
  }
  const auto point = ContactPointOf(std::span(p_F.data(), active),
                                    std::span(intensity.data(), active), Division::kTwice);
  if (!point) return NoPlace(TouchPlace::Status::kNoContact, flaws.any());
  const auto place_F = surface_.Project(point->c);
  if (!place_F) return NoPlace(TouchPlace::Status::kAtOrigin, flaws.any());
  const bool is_flawed = flaws.any() || (active > 1 && clipped == active);
  return FoundPlace(surface_, *place_F, kSigmaAngle, is_flawed, static_cast<int>(active));
}

}  // namespace palpate
