#include "slave/mechanics/factory/tool_domain.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include <Eigen/Geometry>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/mesh_resolution.h"
#include "slave/mechanics/plate/plate_law.h"
#include "slave/mesh/boundary_patch.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

// Contact width of a round tool at a depth of a tenth of its radius, relative to the shaft's width.
// [by Hertz]
constexpr double kRoundWidth = 0.3;
constexpr double kNarrowest = 1e-3;  // smallest contact width relative to l, also used for a point
// Discretisation error of `extruded` [-]. Its elements begin to lock at a Poisson ratio of 0.49.
// [measured: five blocks of extruded_model_test, within 3 %; nu = 0.49 by presses.py, 4.8 %]
constexpr double kExtrudedError = 0.03, kLockingError = 0.05, kExtrudedLocks = 0.49;
// Smallest extent of a tool relative to its width, from the same blocks.
constexpr double kMinExtent = 0.25;
// Of what glue adds to the force of a flat face. [measured: round 0.5 in the plane, nu 0.23 and
// 0.33, test_extremes; six presses of flat tools on arcs, against pressed_profile.py of the
// campaigns, 0.7 to 2.8 %]
constexpr double kOfGluedFace = 0.6;
// Error of laws for small strain in the force of a rigid tool on a volume, by the depth beyond
// kSmallDepth, both relative to the thickness below it. [measured against the neo-Hookean law, disc
// of 20 mm on 60 x 60 x 30 mm: linear 4, 6 and 8 % at depths of 0.1, 0.15 and 0.2; corotational 6
// and 12 % at 0.1 and 0.2 with nu = 0.3, 12 and 24 % with 0.45]
constexpr double kSmallDepth = 0.03, kOfLinear = 0.55;
constexpr double kOfCorotational = 0.85, kCorotationalAt = 0.3, kCorotationalByRatio = 5.5;
constexpr double kUnsure = 0.1;  // relative error of g [measured: plane_thickness.py]
constexpr double kNear = 1e-6;   // of the body's size: the surface itself

// L and l of tool_domain.h, which explains the other symbols, too.
struct Lengths {
  double larger = 0, smaller = 0;  // [m]
};
Lengths LengthsOf(const BoundaryMesh& mesh) {
  const OutlineSize size = SizeOfOutline(mesh);
  const double smaller = std::min(size.sides.minCoeff(), 4 * std::abs(size.area) / size.perimeter);
  return {size.sides.maxCoeff(), smaller};
}

// Returns R. `width`: that of the contact, relative to l; `slenderness`: L / l.
double PlaneShare(double nu, double width, double slenderness) {
  const double y = 0.13 * slenderness * (std::pow(width, 0.6) + 0.6 * std::pow(width, 1.5));
  const double layer = 1 - (1 - 2 * nu) / ((1 - nu) * (1 - nu));
  return std::min(nu * nu + (layer - nu * nu) * y / (1 + y), 0.99);
}

// The largest error for thickness shares g within kUnsure, divided by T / b.
double LargestError(Plane plane, double g, double R, double narrower) {
  double largest = 0;
  for (const double share : {g * (1 - kUnsure), g * (1 + kUnsure)}) {
    for (const double by : {1.0, narrower}) {
      double ratio = (1 - share * R) * std::pow(by, share);
      if (plane == Plane::kStrain) ratio /= 1 - R;
      largest = std::max(largest, std::abs(ratio - 1));
    }
  }
  return largest;
}

// Returns the relative error of a bonded tool that touches one place after another, if each sticks
// where it is at rest: see tool_domain.h.
double LateBondError(const Scene& scene) {
  ModelOptions model = scene.model;
  model.kind = KindOf(scene).name;
  const bool has_path = FollowsTools(model);
  if (model.contact != ContactLaw::kBonded || has_path || IsSkin(scene.object.geometry)) return 0;
  const bool is_stress = KindOf(scene).is_plane && scene.model.plane == Plane::kStress;
  const double given = scene.object.material.poisson_ratio;
  const double nu = is_stress ? given / (1 + given) : given, rest = 1 - 2 * nu;
  return rest > 0 ? kOfGluedFace * ((1 - nu) * std::log1p(2 * rest) / rest - 1) : 0;
}

// Returns by how much the law's error rises with the depth [thickness].
double LawSlope(const Scene& scene) {
  if (!KindOf(scene).iterates || scene.model.fem.law == FemOptions::Law::kLinear) return kOfLinear;
  if (IsHyperelastic(scene.model.fem.law)) return 0;
  const double beyond = std::max(0.0, scene.object.material.poisson_ratio - kCorotationalAt);
  return kOfCorotational + kCorotationalByRatio * beyond;
}

// Returns the distance from `p_O` to the other side of the body along `inward`; infinite: there is
// none. Sides that face the tool do not count: `p_O` may lie somewhat outside of its own.
double ThicknessBelow(const BoundaryMesh& mesh, const Eigen::Vector2d& p_O,
                      const Eigen::Vector2d& inward) noexcept {
  const double near = kNear * mesh.length_unit;
  double nearest = std::numeric_limits<double>::infinity();
  for (const BoundaryElement& e : mesh.elements) {
    const Eigen::Vector2d side = e.b - e.a, from = e.a - p_O;
    const double cross = inward.x() * side.y() - inward.y() * side.x();
    if (!(cross > 0)) continue;
    const double along = (from.x() * side.y() - from.y() * side.x()) / cross;
    const double at = (from.x() * inward.y() - from.y() * inward.x()) / cross;
    if (along > near && at >= 0 && at <= 1) nearest = std::min(nearest, along);
  }
  return nearest;
}
// Moeller and Trumbore 1997.
double ThicknessBelow(const SurfaceMesh& mesh, const Eigen::Vector3d& p_O,
                      const Eigen::Vector3d& inward, double near) noexcept {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d& corner = mesh.nodes[Index(a)];
    const Eigen::Vector3d u = mesh.nodes[Index(b)] - corner, v = mesh.nodes[Index(c)] - corner;
    const Eigen::Vector3d across = inward.cross(v), from = p_O - corner;
    const double volume = u.dot(across);
    if (!(volume < 0)) continue;
    const Eigen::Vector3d turned = from.cross(u);
    const double s = from.dot(across) / volume, t = inward.dot(turned) / volume;
    const double along = v.dot(turned) / volume;
    if (along > near && s >= 0 && t >= 0 && s + t <= 1) nearest = std::min(nearest, along);
  }
  return nearest;
}

// Returns the largest difference in height of the outline under a flat tool, along its chord.
double SagittaOf(const BoundaryMesh& mesh, int element, const Eigen::Vector2d& p_O, double width) {
  const std::vector<int> patch = PatchElements(mesh, element, p_O, width);
  if (patch.empty()) return 0;
  const Eigen::Vector2d from = mesh.elements[Index(patch.front())].a,
                        chord = mesh.elements[Index(patch.back())].b - from;
  double low = 0, high = 0;
  for (const int e : patch) {
    const double height = Cross(chord, mesh.elements[Index(e)].b - from) / chord.norm();
    low = std::min(low, height);
    high = std::max(high, height);
  }
  return high - low;
}

}  // namespace

OutlineSize SizeOfOutline(const BoundaryMesh& mesh) {
  OutlineSize size;
  Eigen::AlignedBox2d box;
  for (const BoundaryElement& e : mesh.elements) {
    box.extend(e.a);
    size.area += 0.5 * Cross(e.a, e.b);
    size.perimeter += e.length();
  }
  size.sides = box.sizes();
  return size;
}

double TouchedWidth(const Tool& tool) {
  const double shaft = tool.width > 0 ? tool.width : 2 * tool.radius;
  return tool.shape == Tool::Shape::kRound ? kRoundWidth * shaft : shaft;
}

double PlaneError(const Scene& scene, const Tool& tool, const ObjectMesh& mesh) {
  const auto* outline = std::get_if<BoundaryMesh>(&mesh);
  if (outline == nullptr) return 0;
  if (!KindOf(scene).is_plane) {
    return scene.object.material.poisson_ratio >= kExtrudedLocks ? kLockingError : kExtrudedError;
  }
  if (!tool.depth) return std::numeric_limits<double>::infinity();
  const Lengths lengths = LengthsOf(*outline);
  const double l = lengths.smaller, T = ThicknessOf(scene.object.geometry);
  const double width = std::max(TouchedWidth(tool) / l, kNarrowest);
  const double R = PlaneShare(scene.object.material.poisson_ratio, width, lengths.larger / l);
  const double x = 0.53 * std::pow(T / l, 0.8) / std::cbrt(width);
  return LargestError(scene.model.plane, x / (1 + x), R, std::max(1.0, T / *tool.depth));
}

double RigidFaceError(const PlatePress& press) noexcept {
  const double a = press.radius, r = press.tool_radius / a, depth = std::abs(press.depth);
  const double narrow = 1 + 0.9 * press.thickness / press.tool_radius;
  const double outermost = std::min(press.place / a + r, 1.0);
  const double law = narrow * plate::ExcessAtDepth({.place = outermost,
                                                    .deflection = press.bends_only ? 0 : depth / a,
                                                    .slenderness = press.thickness / a});
  if (!press.bends_only) return law;
  const double stretched = (0.45 + 0.4 * r + 3 * r * r) * std::pow(depth / press.thickness, 2);
  return std::max(law, stretched);
}

ToolDomain::ToolDomain(const Scene& scene, const Tool& tool, const ObjectMesh& mesh)
    : error_(PlaneError(scene, tool, mesh)),
      tolerance_(scene.model.tolerance),
      is_flat_(tool.shape == Tool::Shape::kFlat) {
  const bool is_plane = KindOf(scene).is_plane;
  if (is_plane && error_ > scene.model.tolerance) {
    Tool through = tool;
    through.depth = std::numeric_limits<double>::infinity();
    const bool thick = PlaneError(scene, through, mesh) > scene.model.tolerance;
    flag_reason_ = !tool.depth ? kExtentUnknown : thick ? kNeitherThinNorThick : kExtentTooSmall;
  }
  if (std::holds_alternative<BoundaryMesh>(mesh) && !is_plane) {
    is_glued_ = true;
    if (error_ > scene.model.tolerance) flag_reason_ = kExtrudedMesh;
    const double T = ThicknessOf(scene.object.geometry);
    if (tool.depth != scene.tool->depth) flag_reason_ = kOtherExtent;
    if (std::min(tool.depth.value_or(T), T) < kMinExtent * tool.width) flag_reason_ = kShortExtent;
  }
  is_quadratic_ = scene.model.fem.element == FemOptions::Element::kTet10;
  const double late_bond = LateBondError(scene);
  if (is_flat_) {
    late_bond_ = late_bond;
  } else {
    error_ += late_bond;
    if (flag_reason_.empty() && late_bond > tolerance_) flag_reason_ = kBondedRound;
  }
  const bool has_four_nodes =
      KindOf(scene).iterates && scene.model.fem.element == FemOptions::Element::kTet4;
  locks_ = has_four_nodes && scene.object.material.poisson_ratio >= kLocks;
  if (KindOf(scene).iterates && IsHyperelastic(scene.model.fem.law)) deepest_ = kDeepestByLaw;
  law_slope_ = LawSlope(scene);
  if (const auto* outline = std::get_if<BoundaryMesh>(&mesh)) outline_ = *outline;
  surface_ = SurfaceOf(mesh);
  const auto* disc = std::get_if<MembraneDisc>(&mesh);
  if (disc != nullptr && tool.IsRigidFace()) {
    plate_.radius = disc->radius;
    plate_.thickness = disc->thickness;
    plate_.bends_only = !KindOf(scene).takes_tension;
  }
}

ToolDomain::Under ToolDomain::UnderTool(const Contact& contact) const {
  if (!is_flat_) return {};
  if (!outline_.elements.empty()) {
    const Eigen::Vector2d p_O = contact.p_O.head<2>();
    const int element = contact.element >= 0 ? contact.element : FindElement(outline_, p_O);
    if (element < 0) return {};
    return {-contact.prescribed_O.head<2>().dot(outline_.elements[Index(element)].normal()),
            SagittaOf(outline_, element, p_O, contact.width)};
  }
  if (surface_.triangles.empty()) return {};
  const auto place = FindPlace(surface_, contact.p_O);
  if (!place || place->triangle < 0) return {};
  const Eigen::Vector3d inward = -Normal(surface_, place->triangle);
  double fall = 0;
  for (const auto& triangle : surface_.triangles) {
    for (const int node : triangle) {
      const Eigen::Vector3d from = surface_.nodes[Index(node)] - contact.p_O;
      const double below = from.dot(inward);
      const bool is_under = (from - below * inward).norm() < contact.width / 2;
      if (is_under && below < contact.width / 2) fall = std::max(fall, below);
    }
  }
  return {contact.prescribed_O.dot(inward), fall};
}

double ToolDomain::ErrorOnCurved(const Contact& contact, int touching) const {
  const auto [depth, below] = UnderTool(contact);
  const double fall = std::min(below, depth);  // what lies deeper does not touch
  if (!(fall > 0)) return 0;
  double facets = 0;
  if (!surface_.triangles.empty() && touching > 0) {
    facets = (is_quadratic_ ? 4 : 1) * fall / touching / (depth - fall / 2);
  }
  return facets + late_bond_ * fall / depth;
}

double ToolDomain::LawError(double share) const {
  return share > kSmallDepth ? law_slope_ * (share - kSmallDepth) : 0;
}

std::string_view ToolDomain::FlagOnBody(const Contact& contact, double* law_error) const {
  if (!outline_.elements.empty()) {
    const Eigen::Vector2d p_O = contact.p_O.head<2>();
    const int element = contact.element >= 0 ? contact.element : FindElement(outline_, p_O);
    if (element < 0) return {};
    const Eigen::Vector2d inward = -outline_.elements[Index(element)].normal();
    const double depth = contact.prescribed_O.head<2>().dot(inward);
    if (depth > deepest_ * ThicknessBelow(outline_, p_O, inward)) return kDeepInThickness;
    const double sagitta = is_glued_ ? UnderTool(contact).fall : 0;
    return depth > 0 && depth < kDepthPerSagitta * sagitta ? kFlatOnCurved : std::string_view();
  }
  if (surface_.triangles.empty()) return {};
  const auto place = FindPlace(surface_, contact.p_O);
  if (!place || place->triangle < 0) return {};
  const Eigen::Vector3d inward = -Normal(surface_, place->triangle);
  const double depth = contact.prescribed_O.dot(inward);
  if (!(depth > 0)) return {};
  const double near = kNear * LargerSide(surface_.nodes);
  const double share = depth / ThicknessBelow(surface_, contact.p_O, inward, near);
  *law_error = LawError(share);
  return share > deepest_ ? kDeepInThickness : std::string_view();
}

void ToolDomain::FlagOutside(const Contact& contact, ContactResponse* response) const noexcept {
  if (contact.kind != Contact::Kind::kDisplacement) return;
  if (response->validity != Validity::kValid || (is_flat_ && contact.width == 0)) return;
  std::string_view flag_reason = flag_reason_;
  double domain_error = flag_reason_.empty() ? error_ : 0;
  if (plate_.radius > 0) {
    PlatePress press = plate_;
    press.tool_radius = contact.width / 2;
    press.place = contact.p_O.head<2>().norm();
    press.depth = contact.prescribed_O.z();
    if (!contact.is_rigid) {
      flag_reason = kNoToolOnPlate;
    } else {
      domain_error = RigidFaceError(press);
      if (domain_error > tolerance_) flag_reason = kRigidOnPlate;
    }
  }
  if (flag_reason.empty()) {
    double law_error = 0;
    flag_reason = FlagOnBody(contact, &law_error);
    domain_error += ErrorOnCurved(contact, response->touching) + law_error;
  }
  const double force = response->force_O.norm();
  response->force_error = std::hypot(response->force_error, domain_error * force);
  if (flag_reason.empty() && (locks_ || response->force_error > tolerance_ * force)) {
    flag_reason = locks_ ? kLocking : kMeshError;
  }
  if (flag_reason.empty()) return;
  response->validity = Validity::kExtrapolated;
  response->flag_reason = flag_reason;
}

}  // namespace palpate
