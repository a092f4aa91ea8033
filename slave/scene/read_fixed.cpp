#include <algorithm>

#include "slave/scene/sections.h"

namespace palpate {
namespace {

template <typename... Kinds>
bool IsOneOf(const Geometry& geometry) {
  return (std::holds_alternative<Kinds>(geometry) || ...);
}

FixedSide ReadSide(Section& section, const Geometry& geometry) {
  constexpr std::array kSides{"bottom", "top", "left", "right"};
  const bool is_flat = IsPlanar(geometry) || IsSkin(geometry);
  const bool has_sides =
      IsPlanar(geometry) && !IsOneOf<DiscGeometry, ImageContourGeometry>(geometry);
  const char* accepted = has_sides ? "bottom, top, left, right or rim"
                         : is_flat ? "rim (or use arc, plane or nodes of an outline)"
                                   : "no side, because this is a volume: use plane or nodes";
  const std::string side = section.Text("side", accepted);
  const bool is_known =
      (has_sides && std::ranges::find(kSides, side) != kSides.end()) || (is_flat && side == "rim");
  if (!side.empty() && !is_known) section.Refuse("side", accepted);
  return {side};
}

FixedArc ReadArc(Section& section, const Geometry& geometry) {
  if (IsOneOf<RectangleGeometry>(geometry) || !IsPlanar(geometry)) {
    section.Refuse("arc", "no arc with this geometry: use side, plane or nodes");
  }
  Section arc = section.Open("arc");
  const double centre = arc.Number("centre");
  return {centre, arc.Number("half_angle")};
}

FixedPlane ReadPlane(Section& section, const Geometry& geometry) {
  Section plane = section.Open("plane");
  const bool is_planar = IsPlanar(geometry);
  if (plane.present() && !plane.Has("axis")) {
    plane.Refuse("axis", is_planar ? "x or y" : "x, y or z");
  }
  const int axis = is_planar ? plane.OneOf<int>("axis", {{"x", 0}, {"y", 1}})
                             : plane.OneOf<int>("axis", {{"x", 0}, {"y", 1}, {"z", 2}});
  return {axis, plane.Number("at")};
}

FixedNodes ReadNodes(Section& section) {
  constexpr const char* kAccepted = "a list of element (in 3D node) indices from 0";
  Section list = section.OpenList("nodes", kAccepted);
  FixedNodes fixed;
  if (list.present() && list.size() == 0) section.Refuse("nodes", kAccepted);
  for (std::size_t i = 0; i < list.size(); ++i) {
    fixed.nodes.push_back(list.Integer(std::to_string(i)));
  }
  return fixed;
}

Fixed ReadFixedEntry(Section& section, const Geometry& geometry) {
  constexpr const char* kOneOf = "exactly one of side, arc, plane, nodes";
  constexpr std::array kKinds{"side", "arc", "plane", "nodes"};
  Fixed fixed;
  if (!section.present()) return fixed;  // no map, which is reported already
  const auto found =
      std::ranges::count_if(kKinds, [&](const char* kind) { return section.Has(kind); });
  if (found != 1) {
    section.mistakes()->Add(*section.node(), section.path(), kOneOf);
    return fixed;
  }
  if (IsSkin(geometry) && !section.Has("side")) {
    section.mistakes()->Add(*section.node(), section.path(),
                            "{side: rim}, because a membrane is clamped");
    return fixed;
  }
  if (section.Has("side")) fixed.where = ReadSide(section, geometry);
  if (section.Has("arc")) fixed.where = ReadArc(section, geometry);
  if (section.Has("plane")) fixed.where = ReadPlane(section, geometry);
  if (section.Has("nodes")) fixed.where = ReadNodes(section);
  return fixed;
}

}  // namespace

std::vector<Fixed> ReadFixed(Section& object, const Geometry& geometry) {
  std::vector<Fixed> fixed;
  if (!object.Has("fixed")) return fixed;
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

}  // namespace palpate
