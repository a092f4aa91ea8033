// Reports and targets of a manipulator that an external driver moves.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/state/clock.h"

namespace palpate {

// A measurement of the driver. Frame S.
struct ArmReading {
  std::uint64_t sequence = 0;
  Time measured_at{};  // driver's clock
  Eigen::Vector3d p_S_tip{0, 0, 0};
  std::optional<Eigen::Quaterniond> R_S_tool;  // nullopt: not measured
  std::optional<Eigen::Vector3d> force;        // of the object on the tool [N]
  bool at_limit = false;
  std::string fault;  // empty: none
};

struct ArmAim {
  enum class Motion : std::uint8_t { kFollow, kHold, kStop } motion = Motion::kHold;
  std::uint64_t sequence = 0;
  Eigen::Vector3d p_S_tip{0, 0, 0}, velocity{0, 0, 0};  // [m], [m/s]
  std::optional<Eigen::Quaterniond> R_S_tool{};
  std::optional<Time> echo{};  // driver's clock
};

// Status for people.
struct ArmHealth {
  std::string driver, fault;             // empty: no driver; no fault
  std::optional<double> lag{}, scale{};  // [s], [-]
  std::uint64_t reports = 0;
  double rate = 0;  // of reports [Hz]
};

using DriverId = std::uint64_t;  // never 0

// Why a reading is not used.
struct DriverRefusal {
  std::string why;
  bool is_held = false;  // refused only because another driver holds the arm
  bool operator==(const DriverRefusal&) const = default;
};

}  // namespace palpate
