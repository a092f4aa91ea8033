#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "shared/mesh/outline_check.h"
#include "shared/scene/contour_file.h"
#include "shared/scene/sections.h"

namespace palpate {
namespace {

constexpr std::size_t kMostPoints = 4000;

double ReadThickness(Section& section) {
  return section.Number("thickness", Positive(Dimension::kLength));
}

Geometry ReadPolygon(Section& geometry) {
  Section section = geometry.Open("polygon");
  const Rule place = Any(Dimension::kLength);
  PolygonGeometry polygon;
  polygon.thickness = ReadThickness(section);
  const std::size_t mistakes_before = section.mistakes()->count();
  polygon.outline.outer = section.Points("points", place);
  std::size_t points = polygon.outline.outer.size();
  Section holes = section.OpenList("holes");
  for (std::size_t i = 0; i < holes.size() && points <= kMostPoints; ++i) {
    polygon.outline.holes.push_back(holes.Points(std::to_string(i), place));
    points += polygon.outline.holes.back().size();
  }
  if (section.mistakes()->count() > mistakes_before) return polygon;
  if (points > kMostPoints) {
    section.Refuse("points", "at most 4000 points, holes included");
    return polygon;
  }
  try {
    CheckOutline(polygon.outline);
  } catch (const std::invalid_argument& error) {
    section.Refuse("points", std::string("a simple polygon with holes inside; ") + error.what());
  }
  return polygon;
}

// `contour` and `thickness` stand side by side in `geometry`.
Geometry ReadContourGeometry(Section& geometry, const SceneContext& context) {
  constexpr const char* kAccepted = "from-image, or a CSV file of x,y";
  const std::string source = geometry.Text("contour", kAccepted);
  const double thickness = ReadThickness(geometry);
  if (source == "from-image") return ImageContourGeometry{thickness};
  ContourFileGeometry contour{context.folder / source, {}, thickness};
  if (source.empty()) return contour;
  try {
    contour.outline.outer = ReadContourFile(contour.file);
    CheckOutline(contour.outline);
  } catch (const std::invalid_argument& error) {
    geometry.Refuse("contour", std::string(kAccepted) + " around an area; " + error.what());
  }
  return contour;
}

Geometry ReadGeometry(Section& object, const SceneContext& context) {
  constexpr const char* kOneOf = "exactly one of rectangle, disc, polygon, contour in this version";
  Section section = object.Open("geometry", kOneOf);
  constexpr std::array kKinds{"rectangle", "disc", "polygon", "contour"};
  const auto found =
      std::ranges::count_if(kKinds, [&](const char* kind) { return section.Has(kind); });
  bool is_later = false;
  for (const char* kind : {"membrane", "box", "mesh"}) {
    is_later |= section.present() && section.node()->Find(kind) != nullptr;
    section.RefuseLater(kind, "rectangle, disc, polygon or contour");
  }
  if (section.present() && found != 1 && !is_later) {
    object.Refuse("geometry", kOneOf);
  }
  const Rule size = Positive(Dimension::kLength);
  if (section.Has("disc")) {
    Section disc = section.Open("disc");
    return DiscGeometry{disc.Number("radius", size), ReadThickness(disc)};
  }
  if (section.Has("polygon")) return ReadPolygon(section);
  if (section.Has("contour")) return ReadContourGeometry(section, context);
  Section rectangle = section.Open("rectangle");
  return RectangleGeometry{rectangle.Number("width", size), rectangle.Number("height", size),
                           ReadThickness(rectangle)};
}

Material ReadMaterial(Section& object) {
  Section section = object.Open("material", "a map of young_modulus, poisson_ratio, ...");
  Material material;
  material.young_modulus = section.Number("young_modulus", Positive(Dimension::kPressure));
  // Just above -1 the plane's stiffness is still a number.
  material.poisson_ratio =
      section.Number("poisson_ratio",
                     Between(Dimension::kNumber, std::nextafter(-1.0, 0.0), 0.5, "-1 < nu <= 0.5"));
  material.density = section.Number("density", Positive(Dimension::kDensity), 0.0);
  material.young_modulus_tolerance =
      section.Number("tolerance", Between(Dimension::kNumber, 0, 1, "0 to 1"), 0.0);
  return material;
}

template <typename... Kinds>
bool IsOneOf(const Geometry& geometry) {
  return (std::holds_alternative<Kinds>(geometry) || ...);
}

FixedSide ReadSide(Section& section, const Geometry& geometry) {
  constexpr std::array kSides{"bottom", "top", "left", "right"};
  const bool has_sides = !IsOneOf<DiscGeometry, ImageContourGeometry>(geometry);
  const char* accepted = has_sides ? "bottom, top, left or right"
                                   : "no side of this geometry: use arc, plane or nodes";
  const std::string side = section.Text("side", accepted);
  const bool is_known = has_sides && std::ranges::find(kSides, side) != kSides.end();
  if (!side.empty() && !is_known) section.Refuse("side", accepted);
  return {side};
}

FixedArc ReadArc(Section& section, const Geometry& geometry) {
  if (IsOneOf<RectangleGeometry>(geometry)) {
    section.Refuse("arc", "no arc of a rectangle: use side, plane or nodes");
  }
  Section arc = section.Open("arc");
  const double centre = arc.Number("centre", Any(Dimension::kAngle));
  const Rule half = Between(Dimension::kAngle, kSmallest, std::numbers::pi, "> 0, at most 180 deg");
  return {centre, arc.Number("half_angle", half)};
}

FixedPlane ReadPlane(Section& section) {
  using Axis = Section::Choice<int>;
  Section plane = section.Open("plane");
  if (plane.present() && !plane.Has("axis")) plane.Refuse("axis", "x or y");
  const int axis = plane.OneOf("axis", std::array{Axis{"x", 0}, Axis{"y", 1}});
  return {axis, plane.Number("at", Any(Dimension::kLength))};
}

FixedNodes ReadNodes(Section& section) {
  constexpr const char* kAccepted = "a list of element indices from 0";
  Section list = section.OpenList("nodes", kAccepted);
  FixedNodes fixed;
  if (list.present() && list.size() == 0) section.Refuse("nodes", kAccepted);
  for (std::size_t i = 0; i < list.size(); ++i) {
    fixed.nodes.push_back(list.Integer(std::to_string(i), 0, static_cast<int>(kMostPoints) - 1));
  }
  return fixed;
}

// `x`, `xy` or `[x, y]`.
std::array<bool, 3> ReadComponents(Section& section) {
  constexpr const char* kAccepted = "x, y, xy or [x, y]";
  if (!section.Has("components")) return {true, true, true};
  const DocumentNode& node = *section.node()->Find("components");
  std::string letters = node.text;
  for (const auto& item : node.children) letters += item.text;
  std::array<bool, 3> held{false, false, false};
  for (const char letter : letters) {
    if (letter == 'x') held[0] = true;
    if (letter == 'y') held[1] = true;
  }
  const bool is_understood = letters.find_first_not_of("xy") == std::string::npos;
  if (letters.empty() || !is_understood) section.Refuse("components", kAccepted);
  return held;
}

Fixed ReadFixedEntry(Section& section, const Geometry& geometry) {
  constexpr const char* kOneOf = "exactly one of side, arc, plane, nodes";
  constexpr std::array kKinds{"side", "arc", "plane", "nodes"};
  Fixed fixed;
  fixed.components = ReadComponents(section);
  const auto found =
      std::ranges::count_if(kKinds, [&](const char* kind) { return section.Has(kind); });
  if (section.present() && found != 1) {
    section.mistakes()->Add(*section.node(), section.path(), kOneOf);
    return fixed;
  }
  if (section.Has("side")) fixed.where = ReadSide(section, geometry);
  if (section.Has("arc")) fixed.where = ReadArc(section, geometry);
  if (section.Has("plane")) fixed.where = ReadPlane(section);
  if (section.Has("nodes")) fixed.where = ReadNodes(section);
  return fixed;
}

std::vector<Fixed> ReadFixed(Section& object, const SceneContext& context,
                             const Geometry& geometry) {
  std::vector<Fixed> fixed;
  if (!object.Has("fixed")) {
    if (context.use == SceneUse::kFull) {
      object.Refuse("fixed", "where the object is held: side, arc, plane or nodes");
    }
    return fixed;
  }
  if (object.node()->Find("fixed")->kind == DocumentNode::Kind::kList) {
    Section list = object.OpenList("fixed");
    for (std::size_t i = 0; i < list.size(); ++i) {
      Section entry = list.Open(std::to_string(i));
      fixed.push_back(ReadFixedEntry(entry, geometry));
    }
    if (list.size() == 0) object.Refuse("fixed", "one {side: ...} or more");
    return fixed;
  }
  Section entry = object.Open("fixed");
  return {ReadFixedEntry(entry, geometry)};
}

}  // namespace

Object ReadObject(Section& scene, const SceneContext& context) {
  Section section = scene.Open("object", "a map of geometry, material, fixed, ...");
  Object object;
  object.geometry = ReadGeometry(section, context);
  object.X_SO = ReadPlanarPose(section, Eigen::Isometry3d::Identity());
  object.material = ReadMaterial(section);
  object.fixed = ReadFixed(section, context, object.geometry);
  return object;
}

}  // namespace palpate
