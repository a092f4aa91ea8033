// Operator, manipulator, link and simulated environment of a scene. SI units, frames as named.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>
#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/geometry/teleop_transform.h"
#include "shared/state/dead_after.h"

namespace palpate {

struct OperatorOptions {
  TeleopTransform transform;   // scales and R_SM; the clutch sets the offset
  double force_limit = 3.3;    // at the device [N]
  double press_depth = 0.005;  // indentation of the simulated operator, at the tool [m]
  bool press_given = false;    // the scene defines press_depth
  double press_speed = 0.020;  // speed of the simulated operator, at the tool [m/s]
};
struct ManipulatorOptions {
  enum class Source : std::uint8_t {
    kSimulated,
    kStream,  // DriveTool
    kNone     // `manipulator: none`: the slave commands no tool and compares no encoders
  } source = Source::kSimulated;
  // Longest time between reports of a driver; a longer silence is a fault [s].
  double silence = 0.040;
  Eigen::Vector3d home{0, 0, 0};                    // tool tip at the start, S [m]
  double max_speed = 0.05;                          // largest tool speed [m/s]
  double max_angular_speed = std::numbers::pi / 2;  // of the tool's rotation [rad/s]
  Eigen::Vector3d workspace_min{-1, -1, 0};         // lower corner of the workspace, S [m]
  Eigen::Vector3d workspace_max{1, 1, 0};           // upper corner of the workspace, S [m]
  // Protection of the object: beyond these limits the tool moves no deeper.
  double force_guard = std::numeric_limits<double>::infinity();  // [N]
  double depth_guard = std::numeric_limits<double>::infinity();  // [m]
  bool guard_retracts = false;  // retract to the surface; otherwise hold
  double blind_after = 0.25;    // the tool holds after the force was unknown for this time [s]
};
struct LinkOptions {
  // Silence after which both ends regard the link as lost [s]: the tool holds and the rendered
  // force fades.
  double dead_after = kUsualDeadAfter;
};
// Properties of a simulated embryo (`site.embryo`). The seed determines the depth of the puncture
// and the target inside the cell.
struct EmbryoSite {
  double radius = 0;        // radius of the true outline, for `contour: from-image` [m]
  double linear_to = 1e-4;  // depth at which the membrane begins to stiffen [m]
  double stiffening = 0.3;  // force relative to the linear one at twice that depth, minus 1 [-]
  Eigen::Vector2d puncture{5e-5, 2e-4};  // range of depths at which the membrane breaks [m]
  double drag = 1e-4;                    // drag of the liquid on the pipette [N s/m]
  int debris = 12;                       // number of particles that drift in the image
  double defocus = 0.4;                  // largest blur of a varying focus, as sigma [px]
};
// The simulated environment, unknown to the estimator.
struct SiteOptions {
  std::uint32_t seed = 1;
  double noise = 2.0;                  // sigma of the image noise [grey levels of 255]
  double blur = 0.7;                   // sigma of the optical blur [px]
  double lighting = 0.15;              // relative decrease of the light across the image [-]
  double flicker = 0.02;               // relative change of the light over time [-]
  Eigen::Vector2d misplacement{0, 0};  // true position of the object relative to the scene, S [m]
  double pace = 1;  // speed factor of a textured target; 1: path of paper C, at most 17 mm/s
  // Rigid motion of the object in front of one camera, such as breathing: a sine with this
  // amplitude, S [m], and period [s], about the rest position.
  struct Motion {
    Eigen::Vector2d amplitude{0, 0};
    double period = 3;
  };
  Motion motion;
  std::optional<EmbryoSite> embryo;
  // A person who holds the tool before one camera with an unknown lens.
  struct Hand {
    double tilt = 0;      // largest angle of the tool in the image plane [rad]
    double tremor = 0;    // amplitude of the tremor, 8 to 12 Hz; the slow drift is twice it [m]
    double exposure = 0;  // relative change of the gain by automatic exposure [-]
    double shadow = 0;    // share of the light that the hand's shadow removes at its centre [-]
    double jitter = 0;    // of the intervals between images, relative [-]
    double lens = 0;      // inward shift of the image's corners by the lens, relative [-]
  };
  std::optional<Hand> hand;
  // Half period of a lamp in front of one camera [s]; 0: no lamp. In every second half period of
  // the slave's clock, counted from 1970, an image has a tenth less light. This reveals the true
  // time of capture, independent of the timestamp. Live images only.
  double lamp = 0;
};

}  // namespace palpate
