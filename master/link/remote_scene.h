// What the master needs to know of the slave's scene, from what the slave says of itself.
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
class Capabilities;
}  // namespace v1

// A fingertip as the slave's scene has it.
struct RemoteFingertip {
  std::string name, network, localiser;                // in words, for people
  Eigen::Vector3d p_S_home = Eigen::Vector3d::Zero();  // where it is while the hand is at home [m]
};

struct RemoteScene {
  std::string name, geometry, model, source;  // in words, for people
  std::string version;                        // of the slave's program
  TeleopTransform transform;                  // scales and R_SM, offset zero
  double force_limit = 3.3;                   // at the device [N]
  std::uint32_t settings_revision = 0;        // of all of this; 0: not told
  double press_depth = 0, press_speed = 0;    // for a scripted hand, at the tool [m], [m/s]
  double dead_after = kUsualDeadAfter;        // silence after which the link is dead [s]
  bool simulated = false;
  double sensor_rate = 0;                   // [Hz]
  std::vector<RemoteFingertip> fingertips;  // the first moves with the hand; empty: cameras
};

// Throws std::runtime_error naming the field: a scale, limit, rotation or rate that cannot be.
RemoteScene ToRemoteScene(const v1::SceneDescription& scene, const v1::Capabilities& capabilities);

// That a slave and a master of these versions, as Version() tells them, are of different releases,
// in words; empty: they are not, or one is not known.
std::string OtherRelease(const std::string& slave, const std::string& master);

}  // namespace palpate
