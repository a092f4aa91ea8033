// The part of the slave's scene that the master needs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "shared/geometry/teleop_transform.h"
#include "shared/state/dead_after.h"

namespace palpate {

namespace v1 {
class SceneDescription;
}  // namespace v1

// A fingertip of the slave's scene.
struct RemoteFingertip {
  std::string name, network;                           // text for people
  Eigen::Vector3d p_S_home = Eigen::Vector3d::Zero();  // position while the device is at home [m]
};

struct RemoteScene {
  std::string name, geometry, model, source;  // text for people
  std::string version;                        // of palpate-slave
  TeleopTransform transform;                  // scales and R_SM, offset zero
  double force_limit = 3.3;                   // at the device [N]
  std::uint32_t settings_revision = 0;        // of these settings; 0: unknown
  double press_depth = 0, press_speed = 0;    // for the simulated operator, at the tool [m], [m/s]
  double dead_after = kUsualDeadAfter;        // link timeout [s]
  bool simulated = false;
  bool accepts_setup = false;               // the page may replace this scene (`serve --setup`)
  double sensor_rate = 0;                   // [Hz]
  std::vector<RemoteFingertip> fingertips;  // the first follows the device; empty: cameras
};

// Throws std::runtime_error with the name of a field that is out of range.
RemoteScene ToRemoteScene(const v1::SceneDescription& scene);

// Largest age of a rendered sample, without its network delay [s]: larger for a slow sensor, up to
// a limit. `sensor_rate`: [Hz], 0: unknown.
double MaxAge(double sensor_rate);

// Returns a text if the versions of slave and master are of different releases; empty if they are
// the same or one is unknown.
std::string OtherRelease(const std::string& slave, const std::string& master);

}  // namespace palpate
