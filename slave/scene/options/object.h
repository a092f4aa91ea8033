// Object and tool of a scene. SI units, frames as named.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/solid_mesh.h"
#include "slave/mesh/outline.h"

namespace palpate {

struct RectangleGeometry {
  double width = 0, height = 0, thickness = 0;
};  // [m], frame O at the lower left
struct DiscGeometry {
  double radius = 0, thickness = 0;
};  // [m], frame O at the centre
struct PolygonGeometry {
  Outline outline;
  double thickness = 0;
};  // [m]
struct ContourFileGeometry {
  std::filesystem::path file;
  Outline outline;
  double thickness = 0;
};  // CSV x,y [m]
struct ImageContourGeometry {
  double thickness = 0;
};  // the outline is found in the first image
struct MembraneGeometry {
  double radius = 0, thickness = 0;
};  // [m], clamped plate, frame O at the centre, z along the outward normal
// An air-filled membrane: the part of an ellipsoid above the plane of its rim, which is fixed.
// Frame O at the rim's centre, z outward through the top.
struct DomeGeometry {
  Eigen::Vector3d semi_axes{0, 0, 0};  // semi-axes of the ellipsoid along x, y, z of O [m]
  double inflation = 0;                // height of the top above the rim [m]
  double thickness = 0;                // thickness of the membrane [m]
  double air = 0;  // volume of the enclosed air [m^3]; 0: its pressure is constant
};
struct BoxGeometry {
  Eigen::Vector3d size{0, 0, 0};
  std::array<int, 3> cells{1, 1, 1};
};  // [m], frame O at the lower corner
// A volume, or a surface that is filled, which is not yet checked.
using GivenMesh = std::variant<SolidMesh, SurfaceMesh>;
struct MeshFileGeometry {
  std::filesystem::path file;
  double unit = 1;        // length of one unit of the file [m]
  double resolution = 0;  // edge of the tetrahedra that fill a surface [m]; 0: chosen by the mesher
  std::shared_ptr<const GivenMesh> given{};  // in memory, in units of `unit`; nullptr: see `file`
};                                           // .node/.ele .msh; a surface: .stl .ply
using Geometry = std::variant<RectangleGeometry, DiscGeometry, PolygonGeometry, ContourFileGeometry,
                              ImageContourGeometry, MembraneGeometry, BoxGeometry, MeshFileGeometry,
                              DomeGeometry>;
bool IsPlanar(const Geometry& geometry);
bool IsVolume(const Geometry& geometry);
// A membrane that is fixed at its rim, flat or domed.
bool IsSkin(const Geometry& geometry);
double ThicknessOf(const Geometry& geometry);  // [m]; 0: a volume
// The outline of a planar geometry, frame O; a disc as a 360-gon. Empty for ImageContourGeometry
// and for geometries that are not planar.
Outline OutlineOf(const Geometry& geometry);

// A part of the moduli that fades at a constant strain as share * exp(-t / time).
struct RelaxationTerm {
  double share = 0;  // share of the instantaneous moduli [-], > 0; the sum of all shares is below 1
  double time = 0;   // [s], > 0
};

struct Material {
  static constexpr std::size_t kMaxRelaxationTerms = 8;

  double young_modulus = 0;                  // E [Pa], > 0; instantaneous for a relaxing material
  double poisson_ratio = 0;                  // nu [-], -1 < nu <= 0.5
  double density = 0;                        // [kg/m^3]; 0: not given
  double young_modulus_tolerance = 0;        // one sigma, relative [-]; part of the force's sigma
  std::vector<RelaxationTerm> relaxation{};  // relaxation of all moduli; empty: elastic
};

// Parts of the boundary with zero displacement.
struct FixedSide {
  std::string side;
};  // bottom, top, left, right of the bounding box, selected by element midpoint
struct FixedArc {
  double centre = 0, half_angle = 0;
};  // angles of element midpoints seen from O's origin [rad], ends included within 1e-9 rad
struct FixedPlane {
  int axis = 0;
  double at = 0;
};  // elements whose midpoint is in the plane at this position [m]
struct FixedNodes {
  std::vector<int> nodes;
};  // element indices from 0
struct Fixed {
  std::variant<FixedSide, FixedArc, FixedPlane, FixedNodes> where;
  // Fixed components x, y, z; no key. With single ones the tests' bodies have uniform stress.
  std::array<bool, 3> components{true, true, true};
};

// A part of a volume with another modulus. Frame O, boundary included.
struct Ball {
  Eigen::Vector3d centre{0, 0, 0};
  double radius = 0;
};  // [m]
struct Region {
  std::variant<Ball, Eigen::AlignedBox3d> where;  // [m]; a layer is a box without other bounds
  double young_modulus = 0;                       // [Pa], > 0
  int line = 0;                                   // of the scene; 0: none

  [[nodiscard]] bool Contains(const Eigen::Vector3d& p_O) const;
};

struct Object {
  Geometry geometry;
  Eigen::Isometry3d X_SO = Eigen::Isometry3d::Identity();
  Material material;
  std::vector<Region> regions;  // where they overlap, the last one counts
  std::vector<Fixed> fixed;     // empty: balanced loads only
};
// Whether the object has a fixed boundary. The rim of a membrane is always fixed. Without a fixed
// boundary the object may move as a rigid body: its points are tracked and the force is unknown.
bool IsHeld(const Object& object);
// The elastic object that a relaxing one becomes in the end: smaller moduli.
Object Relaxed(Object object);
// Young's modulus at a point, frame O, divided by that of the body [-].
double RelativeModulus(const Object& object, const Eigen::Vector3d& p_O);

// --- tool
// A rigid tool: flat (its width, and its extent through a planar object), round (its radius), or a
// capsule. The one type of every model, command, simulator and reference.
struct Tool {
  enum class Shape : std::uint8_t {
    kFlat,
    kRound,
    kCapsule,   // this and the next one: see FollowsTools (model_kinds.h)
    kRectangle  // flat, `length` along `axis_O` and `width` across it
  } shape = Shape::kFlat;
  double width = 0;  // width; of a flat tool the contact width [m], > 0
  // Extent through the thickness of a planar object [m]; infinite: through all of it; nullopt: the
  // scene does not state it.
  std::optional<double> depth{};
  // From the front face of a planar object to the tool [m]; nullopt: it is at the centre.
  std::optional<double> behind{};
  // For a flat tool on a membrane: true: a uniform pressure; false: a rigid face, which is not
  // glued and does not tilt.
  bool presses_evenly = false;
  double radius =
      0;  // of the end of a round tool, or of a capsule [m]; its contact grows with depth
  double length = 0;                // of a capsule's straight part, or of a rectangle [m]
  Eigen::Vector3d axis_O{1, 0, 0};  // unit vector along it
  Eigen::Vector2d direction{
      0, -1};  // unit vector along the tool, in the plane z = 0 of S; zero: found in the image

  // From the front face of a planar object of this thickness to the tool [m]; 0 where its extent is
  // not stated.
  [[nodiscard]] double BehindFront(double thickness) const {
    return depth ? behind.value_or((thickness - std::min(*depth, thickness)) / 2) : 0;
  }
  // Returns whether it reaches through a part of this thickness only.
  [[nodiscard]] bool IsNarrowerThan(double thickness) const { return depth && *depth < thickness; }
  [[nodiscard]] bool IsRigidFace() const { return shape == Shape::kFlat && !presses_evenly; }
};
// Returns the text of tool.shape.
constexpr std::string_view WordOf(Tool::Shape shape) {
  return shape == Tool::Shape::kFlat      ? "flat"
         : shape == Tool::Shape::kRound   ? "round"
         : shape == Tool::Shape::kCapsule ? "capsule"
                                          : "rectangle";
}

}  // namespace palpate
