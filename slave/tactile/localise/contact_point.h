// Where the active electrodes' intensities put the contact (paper B, equations 1 to 3).
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

namespace palpate {

// With the m active electrodes at p_i, intensities I_i:
//
//   x = sum p_i / m,   d_i = (p_i - x) I_i / sum I,   c = x + sum d_i / m
//
// The intensities are normalised already, so the last division by m pulls c towards the centroid x;
// paper and authors' code divide. `kOnce` leaves it out: c is the mean weighted by intensity.
enum class Division : std::uint8_t { kTwice, kOnce };

struct ContactPoint {
  Eigen::Vector3d centroid{0, 0, 0};  // x
  Eigen::Vector3d c{0, 0, 0};
};

// `p` of the active electrodes in any unit, `intensity` >= 0 of each. nullopt: none is active, or
// their intensities are all zero, or not finite. Allocation-free.
std::optional<ContactPoint> ContactPointOf(std::span<const Eigen::Vector3d> p,
                                           std::span<const double> intensity,
                                           Division division) noexcept;

}  // namespace palpate
