// An arm that somebody else's driver moves: what the driver says of it and what it is told.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "shared/state/clock.h"

namespace palpate {

// What a driver measured. Frame S.
struct ArmReading {
  std::uint64_t sequence = 0;
  Time measured_at{};  // driver's clock
  Eigen::Vector3d p_S_tip{0, 0, 0};
  std::optional<Eigen::Vector3d> velocity;           // [m/s]
  std::optional<std::array<double, 4>> orientation;  // w, x, y, z
  std::optional<Eigen::Vector3d> force;              // of the object on the tool [N]
  bool at_limit = false;
  std::string fault;  // empty: none
};

struct ArmAim {
  enum class Motion : std::uint8_t { kFollow, kHold, kStop } motion = Motion::kHold;
  std::uint64_t sequence = 0;
  Eigen::Vector3d p_S_tip{0, 0, 0}, velocity{0, 0, 0};  // [m], [m/s]
  std::optional<std::array<double, 4>> orientation{};   // w, x, y, z
  std::optional<Time> echo{};                           // driver's clock
};

// What becomes of it, for people.
struct ArmHealth {
  std::string driver, fault;             // empty: nobody; nothing
  std::optional<double> lag{}, scale{};  // [s], [-]
  std::uint64_t reports = 0;
  double rate = 0;  // of reports [Hz]
};

// Thread-safe; every call is short.
class DrivenArm {
 public:
  using DriverId = std::uint64_t;  // never 0

  virtual ~DrivenArm() = default;
  // `driver` drives from its first reading on. nullopt: taken. Else why not, in words; what it said
  // is not used.
  virtual std::optional<std::string> Take(DriverId driver, const std::string& name,
                                          const ArmReading& reading, Time arrived_at) = 0;
  // The driver has left, if it drove.
  virtual void Leave(DriverId driver) = 0;
  // Where the arm shall go as of `now`; time passes for the arm from call to call.
  virtual ArmAim Aim(Time now) = 0;
};

}  // namespace palpate
