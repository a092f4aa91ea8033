// Rigid tools pressed into bodies of revolution and prisms with a clamped bottom, as `solve` asks.
#pragma once

#include <string>
#include <vector>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/scene/scene.h"
#include "tests/stability/extremes/bodies.h"

namespace palpate::extremes {

// Bodies and tools of the truths [mm]: radius 30, height 20, a flat top or an arc of radius 60; a
// flat tool of radius 6 or a round one of radius 40.
inline constexpr double kBodyRadius = 30, kBodyHeight = 20, kCapRadius = 60;
inline constexpr double kFaceRadius = 6, kBallRadius = 40;

struct ToolPressed {
  bool is_cap = false, is_round = false;
  double depth = 0;     // [mm]
  double nu = 0;        // [-]
  double friction = 0;  // Coulomb's coefficient; infinite: bonded
  double unit = 1e-3;   // length of one millimetre of the above [m]
  double E = 20e3;      // [Pa]
  bool has_slivers = false;
  int cells = 12;  // across the body

  [[nodiscard]] std::string text() const;
};

// Whether the scene reader accepts a contact of this friction with such a model.
bool TakesFriction(const Family& family, double friction);

// The body of `pressed`, graded to the tool. Slivers: interior nodes below the tool are moved until
// the smallest dihedral angle of one of their tetrahedra is kSliver.
inline constexpr double kSliver = 2;  // [degrees]
SolidMesh PressedBody(const ToolPressed& pressed);
// Smallest dihedral angle of a mesh [degrees].
double SmallestDihedral(const SolidMesh& mesh);
Scene PressScene(const Family& family, const ToolPressed& pressed);
// A prism of 60 x 20 mm and a thickness in mm under a tool that reaches through it, pressed in the
// plane.
Scene PrismScene(const Family& family, const ToolPressed& pressed, double thickness);

struct Pressed {
  double force = 0;  // into the body, by E and mm^2
  double error = 0;  // as stated, relative [-]
  Validity validity = Validity::kFailed;
  std::string_view flag_reason;
  int newton_steps = 0, iterations = 0;  // 0: the model does not count them
};
// Presses the scene's tool by `depth_O` [m] at `p_O` through CaseSolver. Throws
// std::invalid_argument for a refusal or a failure with a reason, and std::runtime_error for a
// failure without one or a value that is not finite.
Pressed PressOnce(const Scene& scene, const ObjectMesh& mesh, const Eigen::Vector3d& p_O,
                  const Eigen::Vector3d& depth_O, double unit);
// The same at the middle of the top of a body or prism.
Pressed PressOnTop(const Family& family, const ToolPressed& pressed);
Pressed PressPrism(const Family& family, const ToolPressed& pressed, double thickness);

}  // namespace palpate::extremes
