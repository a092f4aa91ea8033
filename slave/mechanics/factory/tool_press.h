// A rigid tool pressed into a scene's object. Every command presses through this class, so that a
// tool has the same shape in all of them, with any kind of model.
//
//   flat     a contact of the tool's width, on plates a rigid face or an even load
//   round    bem2d, fem, fem-green: a contact that grows with the depth (Contact::radius)
//            plate, plate-large: a point, see kPointOnPlate
//   fem at rest with four-node tetrahedra computes every tool itself (tool_contact.h)
#pragma once

#include <optional>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/factory/tool_domain.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/scene/scene.h"

namespace palpate {

// Why a round tool on a plate is kExtrapolated. A plate that bends touches a sphere of radius R in
// a point until its curvature there is 1 / R: then it wraps the tool, along a ring of radius
//
//   c = l exp(-4 pi D / (F R)),   l: the radius, or sqrt(D / N) of a plate under the tension N
//
// (Timoshenko and Woinowsky-Krieger, art. 19: the moment inside a loaded ring). And the tool sinks
// into the thickness, which no plate has, by (9 F^2 (1 - nu^2)^2 / (16 E^2 R))^(1/3) (Hertz).
inline constexpr std::string_view kPointOnPlate =
    "the plate wraps the round tool, or the tool sinks into it: its contact is no point";

// Returns whether the contact area of the scene's tool grows with the depth.
[[nodiscard]] bool IsTouchedRound(const Scene& scene);

class ToolPress {
 public:
  // The scene's model presses `tool`, which is flat or round, or the scene's where ShapesTool.
  // Throws std::invalid_argument: a round tool without a radius, or with a model in time.
  ToolPress(const Scene& scene, const Tool& tool, const ObjectMesh& mesh);

  // Computes a press: the tool's centre first touches at `contact.p_O` and has moved by
  // `contact.prescribed_O` since. `contact.width` is used for flat tools only. `solution`: the
  // model's. kFailed without a surface there.
  [[nodiscard]] ContactResponse Press(const Contact& contact, DeformationModel* model,
                                      Solution* solution) noexcept;

 private:
  [[nodiscard]] ContactResponse Answer(const Contact& contact, DeformationModel* model,
                                       Solution* solution) noexcept;
  void CheckPoint(ContactResponse* response) const noexcept;

  ToolDomain domain_;
  double radius_ = 0;  // of a tool whose contact grows [m]; 0: another tool
  bool is_rigid_face_ = false;
  struct Plate {
    double radius = 0, rigidity = 0;  // a [m], D [N m]
    double modulus = 0;               // E / (1 - nu^2) [Pa]
    double tool_radius = 0;           // [m]
  };
  std::optional<Plate> plate_;  // under a round tool
};

}  // namespace palpate
