// Messages of the Haply inverse service (API 3.1 to 3.5), as text. Frame H of the service: x to the
// right, y away from the operator, z up; metres and newtons.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace palpate {

// How a force is written: `values` up to API 3.3, `vector` from 3.5 on. An unknown release gets
// both and uses the one that it supports.
enum class HaplyForm : std::uint8_t { kValues, kVector, kBoth };

// HaplyState holds the values of one state message for the first Inverse3 and the first VerseGrip.
// Frame H.
struct HaplyState {
  std::string id;  // of the Inverse3; empty: none is connected
  bool calibrated = true;
  Eigen::Vector3d position{0, 0, 0};              // [m]
  std::optional<Eigen::Vector3d> velocity;        // [m/s]
  std::optional<Eigen::Vector3d> force;           // that the motors make, of all sessions [N]
  std::optional<Eigen::Quaterniond> orientation;  // of the grip
  std::uint32_t buttons = 0;                      // a, b, c, home from bit 0 on
  bool has_grip = false;                          // connected and awake
  std::optional<double> gate_gain;                // of the force gate [-]; first message only
};
// nullopt: not a state of the service, or numbers that are not finite.
std::optional<HaplyState> ParseHaplyState(const std::string& text);

// The message that commands `force` [N] of the device `id`.
std::string HaplyForceMessage(const std::string& id, const Eigen::Vector3d& force, HaplyForm form);

// Requests a complete state from a service that sends none unrequested.
std::string HaplyStateRequest();

// The form for the release that GET /version reported.
HaplyForm HaplyFormOf(const std::string& version_text);
// `3.5.0` of the same; empty: none.
std::string HaplyRelease(const std::string& version_text);

// HaplySessions holds the answer of GET /sessions.
struct HaplySessions {
  std::size_t count = 0;
  double force_scale = 1;  // global [-]
};
std::optional<HaplySessions> ParseHaplySessions(const std::string& text);

}  // namespace palpate
