// Domains in which the force of a model under a tool was compared with that of a solid. Outside the
// force is `extrapolated`. Models that leave out a dimension have such a domain:
//
// Plane models. A body of thickness T under a tool that reaches b <= T through it is neither in
// plane stress nor in plane strain. With R the share by which plane stress is softer than plane
// strain, bricks in space have, within a tenth of g (tests/slave/mechanics/plane_thickness.py),
//
//   K_stress / K = (1 - g R) (T / b)^g,   K_strain / K = (1 - g R) / (1 - R) (T / b)^g
//   g = x / (1 + x),   x = 0.53 (T / l)^0.8 (l / w)^(1/3)
//   R = nu^2 + (R_layer - nu^2) y / (1 + y),   R_layer = 1 - (1 - 2 nu) / (1 - nu)^2
//   y = 0.13 L / l ((w / l)^0.6 + 0.6 (w / l)^1.5)
//
// for a contact of width w; L: the larger side of the outline's box; l: the smaller one, or 4 A / P
// where that is less. R is nu^2 on a half-plane, R_layer in a thin layer under a wide tool. A tool
// that reaches through a part of the thickness is rated no better than one through all of it,
// because there two errors of opposite sign would cancel.
//
// An extruded outline is a solid: its mesh is made for one extent of the tool, and resolves one of
// at least a quarter of the tool's width.
//
// Plates. Under a rigid flat tool of radius r at p on a plate of radius a and thickness t, w deep,
// neo-Hookean sheets have less force than the plate models by at most
//
//   (7.2 (t/a)^2 / (1 - q^2)^2 + (1.95 + 90 t/a) (w/a)^2 / (1 - q^2)^(3/4)) (1 + 0.9 t / r)
//
// with q a = p + r, of the tool's outermost point (plate_law.h has this under an even load, at its
// centre): for t of a / 80 to a / 40, r of 0.02 to 0.3 a, w up to 4 t and q up to 0.85
// (tests/slave/mechanics/rigid_tool_test.cpp). A plate that bends only lacks the force of
// stretching, (0.45 + 0.4 r/a + 3 (r/a)^2) (w/t)^2 of its own up to w = 0.5 t. A point contact has
// no face, so it has no such domain.
//
// Bonded tools that touch one place after another. A place sticks where the tool touches it, after
// it has moved along the surface. Models without a path let it stick where it was at rest, which is
// too stiff by at most 0.6 of what glue adds to the force of a flat face,
// ((1 - nu) ln(3 - 4 nu) / (1 - 2 nu) - 1) (Spence 1968). Under a flat tool on a curved surface
// that is in proportion to the fall of the surface under it by the depth.
//
// Flat tools on curved volumes. Facets lie below the surface that they stand for, by about G / n
// between n places that a tool touches if it falls by G under what touches; with ten nodes, whose
// mid-edge nodes lie on the facets, by four times that. The force changes by that part of the mean
// depth. [derived: a sphere]
//
// Every body. A tool reaches at most kDeepest of the thickness below it: deeper, small strains and
// the corotational law are a quarter off. On volumes their error rises up to there. With a law for
// large strains that is kDeepestByLaw. The tool of `extruded` takes the shape of the outline, so it
// must be kDepthPerSagitta times as deep as the outline under it is high.
#pragma once

#include <string_view>

#include <Eigen/Core>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/scene/scene.h"

namespace palpate {

inline constexpr std::string_view kExtentUnknown =
    "the scene does not state how far the tool reaches through the thickness: set tool.depth";
inline constexpr std::string_view kExtentTooSmall =
    "the tool is narrower than the object is thick: a plane model is too stiff under it";
inline constexpr std::string_view kNeitherThinNorThick =
    "the object is too thick for plane stress or too thin for plane strain: model.tolerance is "
    "below the error";
inline constexpr std::string_view kOtherExtent =
    "the extruded model is made for another extent of the tool: set tool.depth";
inline constexpr std::string_view kBondedRound =
    "a bonded round tool is too stiff at this Poisson's ratio: use fem with element: tet4";
inline constexpr std::string_view kShortExtent =
    "the tool reaches less far through the thickness than a quarter of its width";
inline constexpr std::string_view kExtrudedMesh =
    "the error of the extruded model's mesh is beyond model.tolerance";
inline constexpr std::string_view kNoToolOnPlate =
    "the scene has no tool: the disc of this width presses evenly; set tool and tool.load";
inline constexpr std::string_view kRigidOnPlate =
    "under a rigid flat tool here the plate's error is beyond model.tolerance";

inline constexpr std::string_view kMeshError =
    "the error of the mesh under the tool is beyond model.tolerance: use smaller elements there";
inline constexpr std::string_view kDeepInThickness =
    "the tool is too deep for the object's thickness there";

inline constexpr std::string_view kFlatOnCurved =
    "the flat tool is not deep enough in this curved outline: the model lets it take its shape";

// Of the thickness [-]. [measured: corotational against neo-Hookean, 24 % low at a fifth of the
// height and nu = 0.45] [by definition, for laws of large strains]
inline constexpr double kDeepest = 0.2, kDeepestByLaw = 0.5;

// Depth relative to the height of the outline under a flat tool, which `extruded` glues to it [-].
// [measured: a glued disc of 18 mm on a cap of 45 mm: 15 to 22 % too stiff at 3.3, 32 to 40 %
// at 2.2]
inline constexpr double kDepthPerSagitta = 5;

struct OutlineSize {
  double perimeter = 0, area = 0;                   // [m], [m^2]
  Eigen::Vector2d sides = Eigen::Vector2d::Zero();  // of the bounding box [m]
};
OutlineSize SizeOfOutline(const BoundaryMesh& mesh);

// Returns the width at which a tool touches a flat surface [m]: of a round tool at a depth of a
// tenth of its radius.
double TouchedWidth(const Tool& tool);

// Returns the relative error of a plane model's force against a solid [-]; infinite: the tool's
// extent is not stated. 0 for other objects.
double PlaneError(const Scene& scene, const Tool& tool, const ObjectMesh& mesh);

// A rigid flat tool on a plate.
struct PlatePress {
  double radius = 0, thickness = 0;              // of the plate [m]
  double tool_radius = 0, place = 0, depth = 0;  // place: distance from the centre [m]
  bool bends_only = false;
};
// Error of the plate model's force, relative [-]: see above.
double RigidFaceError(const PlatePress& press) noexcept;

class ToolDomain {
 public:
  ToolDomain(const Scene& scene, const Tool& tool, const ObjectMesh& mesh);

  // Adds the error of the model within the domain, as an independent one, to the force error of a
  // contact that the tool moves, and makes its response kExtrapolated outside of the domain or
  // where both together are beyond model.tolerance. Loads and contacts at a point stay as they are.
  // No allocation, but on volumes.
  void FlagOutside(const Contact& contact, ContactResponse* response) const noexcept;
  // Relative error of the force within the domain [-].
  [[nodiscard]] double error() const { return flag_reason_.empty() ? error_ : 0; }
  [[nodiscard]] std::string_view flag_reason() const { return flag_reason_; }  // at every place

 private:
  // Sets the relative error of the law on volumes.
  [[nodiscard]] std::string_view FlagOnBody(const Contact& contact, double* law_error) const;
  [[nodiscard]] double LawError(double share) const;
  // A flat tool's depth along the normal, and the fall of the surface or outline under it [m].
  struct Under {
    double depth = 0, fall = 0;
  };
  [[nodiscard]] Under UnderTool(const Contact& contact) const;
  // Relative error of a flat tool's force on a curved surface.
  [[nodiscard]] double ErrorOnCurved(const Contact& contact, int touching) const;

  std::string_view flag_reason_;
  double error_ = 0;
  double tolerance_ = 0;  // [-]
  PlatePress plate_;      // under a rigid flat tool; radius 0: none
  bool is_flat_ = true;
  bool is_glued_ = false;  // the outline under a flat tool moves as a whole
  double deepest_ = kDeepest;
  double law_slope_ = 0;
  bool is_quadratic_ = false;
  double late_bond_ = 0;  // under a flat tool
  bool locks_ = false;    // four-node elements from kLocks on
  BoundaryMesh outline_;  // of the body; empty: another object
  SurfaceMesh surface_;
};

}  // namespace palpate
