#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>

#include "shared/text/file_format.h"
#include "shared/text/text.h"
#include "slave/mesh/outline.h"
#include "slave/scene/contour_file.h"
#include "slave/scene/materials.h"
#include "slave/scene/sections.h"

namespace palpate {
namespace {

double ReadThickness(Section& section) {
  return section.Number("thickness");
}

Geometry ReadPolygon(Section& geometry) {
  Section section = geometry.Open("polygon");
  PolygonGeometry polygon;
  polygon.thickness = ReadThickness(section);
  const std::size_t mistakes_before = section.mistakes()->count();
  polygon.outline.outer = section.Points("points");
  std::size_t points = polygon.outline.outer.size();
  Section holes = section.OpenList("holes");
  for (std::size_t i = 0; i < holes.size() && points <= kMaxOutlinePoints; ++i) {
    polygon.outline.holes.push_back(holes.Points(std::to_string(i)));
    points += polygon.outline.holes.back().size();
  }
  if (section.mistakes()->count() > mistakes_before) return polygon;
  if (points > kMaxOutlinePoints) {
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

// `contour` and `thickness` are side by side in `geometry`.
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

// Flat with a radius, domed with semi-axes.
Geometry ReadMembrane(Section& geometry) {
  Section membrane = geometry.Open("membrane");
  if (!membrane.Has("semi_axes") && !membrane.Has("inflation")) {
    return MembraneGeometry{membrane.Number("radius"), ReadThickness(membrane)};
  }
  DomeGeometry dome;
  const std::size_t before = membrane.mistakes()->count();
  dome.semi_axes = membrane.Vector3("semi_axes");
  dome.inflation = membrane.Number("inflation");
  dome.thickness = ReadThickness(membrane);
  dome.air = membrane.Number("air");
  if (membrane.mistakes()->count() > before) return dome;
  constexpr double kMaxAxesRatio = 10;  // to the shortest
  if (dome.semi_axes.maxCoeff() > kMaxAxesRatio * dome.semi_axes.minCoeff()) {
    membrane.Refuse("semi_axes", "three lengths, at most 10 to 1");
  } else if (dome.inflation > 1.5 * dome.semi_axes.z()) {
    membrane.Refuse("inflation", "at most 1.5 times the semi-axis along z");
  } else if (dome.inflation < 0.05 * dome.semi_axes.z()) {
    membrane.Refuse(
        "inflation",
        "at least a twentieth of the semi-axis along z; for a flat membrane use `radius`");
  }
  return dome;
}

BoxGeometry ReadBox(Section& geometry) {
  Section section = geometry.Open("box");
  BoxGeometry box;
  box.size = section.Vector3("size");
  const Eigen::Vector3d cells = section.Vector3("cells");
  if (cells != cells.array().floor().matrix()) section.Refuse("cells", "three whole numbers");
  for (int i = 0; i < 3; ++i) box.cells[static_cast<std::size_t>(i)] = static_cast<int>(cells[i]);
  constexpr double kMaxTets = 4e6;
  if (6 * cells.prod() > kMaxTets)
    section.Refuse("cells", "cells with at most 4 million tetrahedra");
  return box;
}

// Reads the unit of the file: `mm` or `1 mm`.
double ReadUnit(Section& geometry) {
  const std::string accepted =
      "a unit such as mm, or " + ExpectedQuantity(Dimension::kLength, "> 0");
  const std::string text = geometry.Text("unit", accepted, "1 m");
  const auto bare = ParseQuantity("1 " + text, Dimension::kLength);
  const auto unit = bare ? bare : ParseQuantity(text, Dimension::kLength);
  if (unit && *unit >= kMinValue && *unit <= kMaxValue) return *unit;
  geometry.Refuse("unit", accepted);
  return 1;
}

// `mesh`, `unit` and `resolution` are side by side in `geometry`.
MeshFileGeometry ReadMeshFile(Section& geometry, const SceneContext& context) {
  const std::string accepted =
      "a file that can be read: .node .ele .msh, or a surface .stl .ply; other formats are "
      "converted by meshio";
  constexpr std::array kEndings{".node", ".ele", ".msh", ".stl", ".ply"};
  const std::string name = geometry.Text("mesh", accepted);
  MeshFileGeometry mesh{context.folder / name, ReadUnit(geometry), geometry.Number("resolution")};
  if (name.empty()) return mesh;
  if (context.mesh) {
    mesh.given = context.mesh;
    return mesh;
  }
  std::error_code error;
  const std::string ending = Lowercase(mesh.file.extension().string());
  const bool is_known = std::ranges::find(kEndings, ending) != kEndings.end();
  const bool is_file = std::filesystem::is_regular_file(mesh.file, error);
  if (!is_known || !is_file) {
    const std::string foreign = is_file ? ForeignFile(mesh.file) : "";
    geometry.Refuse("mesh", accepted + (foreign.empty() ? "" : "; it is " + foreign));
  }
  return mesh;
}

std::vector<RelaxationTerm> ReadRelaxation(Section& material) {
  const std::string accepted = "one to " + std::to_string(Material::kMaxRelaxationTerms) +
                               " terms {share: ..., time: ...} whose shares add up to less than 1";
  Section list = material.OpenList("relaxation");
  std::vector<RelaxationTerm> terms;
  const std::size_t before = list.mistakes()->count();
  double left = 1;
  for (std::size_t i = 0; i < list.size(); ++i) {
    Section term = list.Open(std::to_string(i));
    terms.push_back({term.Number("share"), term.Number("time")});
    left -= terms.back().share;
  }
  if (!list.present() || list.mistakes()->count() > before) return terms;
  const bool is_usable = terms.size() > 0 && terms.size() <= Material::kMaxRelaxationTerms;
  if (!is_usable || !(left > 1e-9)) material.Refuse("relaxation", accepted);
  return terms;
}

// Returns the material with this name. Null: there is no name, or the table does not have it, which
// is refused.
const NamedMaterial* ReadName(Section& material) {
  if (!material.Has("name")) return nullptr;
  std::string names;
  for (const NamedMaterial& one : NamedMaterials()) {
    names.append(names.empty() ? "" : ", ").append(one.name);
  }
  const NamedMaterial* named = FindMaterial(material.Text("name", names));
  if (named == nullptr) material.Refuse("name", names);
  return named;
}

Material ReadMaterial(Section& object) {
  Section section = object.Open("material", "a map of young_modulus, poisson_ratio, ...");
  Material material;
  const NamedMaterial* named = ReadName(section);
  const auto known = [&](double value) {
    return named != nullptr && std::isfinite(value) ? std::optional(value) : std::nullopt;
  };
  const NamedMaterial from = named != nullptr ? *named : NamedMaterial{};
  material.young_modulus = section.Number("young_modulus", known(from.young_modulus));
  material.poisson_ratio = section.Number("poisson_ratio", known(from.poisson_ratio));
  material.density = section.Number("density", known(from.density));
  // The tolerance is that of the table's modulus.
  const bool is_own = named == nullptr || section.Has("young_modulus");
  material.young_modulus_tolerance =
      section.Number("tolerance", is_own ? std::nullopt : known(from.tolerance));
  material.relaxation = ReadRelaxation(section);
  return material;
}

Ball ReadBall(Section& region) {
  Section ball = region.Open("sphere");
  const Eigen::Vector3d centre = ball.Vector3("centre");
  return {centre, ball.Number("radius")};
}

Eigen::AlignedBox3d ReadRegionBox(Section& region) {
  Section box = region.Open("box");
  const std::size_t before = box.mistakes()->count();
  const Eigen::Vector3d from = box.Vector3("from"), to = box.Vector3("to");
  const Eigen::AlignedBox3d read(from, to);
  const bool is_mistaken = box.mistakes()->count() > before;
  if (!is_mistaken && !((read.sizes().array() > 0).all())) {
    box.Refuse("to", "more than `from` in every component");
  }
  return read;
}

Eigen::AlignedBox3d ReadLayer(Section& region) {
  Section layer = region.Open("layer");
  if (layer.present() && !layer.Has("axis")) layer.Refuse("axis", "x, y or z");
  const int axis = layer.OneOf<int>("axis", {{"x", 0}, {"y", 1}, {"z", 2}});
  const std::size_t before = layer.mistakes()->count();
  const double from = layer.Number("from"), to = layer.Number("to");
  if (layer.mistakes()->count() == before && !(from < to)) layer.Refuse("to", "more than `from`");
  Eigen::Vector3d lower = Eigen::Vector3d::Constant(-kMaxValue), upper = -lower;
  lower[axis] = from;
  upper[axis] = to;
  return {lower, upper};
}

Region ReadRegion(Section& section) {
  constexpr std::array kKinds{"sphere", "box", "layer"};
  Region region;
  if (!section.present()) return region;  // no map, which is reported already
  region.line = section.node()->is_override ? 0 : section.node()->line;
  region.young_modulus = section.Number("young_modulus");
  const auto found =
      std::ranges::count_if(kKinds, [&](const char* kind) { return section.Has(kind); });
  if (found != 1) {
    section.mistakes()->Add(*section.node(), section.path(), "exactly one of sphere, box, layer");
    return region;
  }
  if (section.Has("sphere")) region.where = ReadBall(section);
  if (section.Has("box")) region.where = ReadRegionBox(section);
  if (section.Has("layer")) region.where = ReadLayer(section);
  return region;
}

std::vector<Region> ReadRegions(Section& object) {
  std::vector<Region> regions;
  Section list = object.OpenList("regions");
  for (std::size_t i = 0; i < list.size(); ++i) {
    Section entry = list.Open(std::to_string(i));
    regions.push_back(ReadRegion(entry));
  }
  if (list.present() && list.size() == 0) {
    object.Refuse("regions", "one {sphere: ..., young_modulus: ...} or more");
  }
  return regions;
}

}  // namespace

Geometry ReadGeometry(Section& object, const SceneContext& context) {
  constexpr std::array kKinds{"rectangle", "disc", "polygon", "contour", "membrane", "box", "mesh"};
  constexpr const char* kOneOf =
      "exactly one of rectangle, disc, polygon, contour, membrane, box, mesh";
  Section section = object.Open("geometry", kOneOf);
  const auto found =
      std::ranges::count_if(kKinds, [&](const char* kind) { return section.Has(kind); });
  if (section.present() && found != 1) {
    // A key that is none of them is reported by itself.
    if (found > 1 || section.size() == 0) object.Refuse("geometry", kOneOf);
    return RectangleGeometry{};
  }
  if (section.Has("membrane")) return ReadMembrane(section);
  if (section.Has("box")) return ReadBox(section);
  if (section.Has("mesh")) return ReadMeshFile(section, context);
  if (section.Has("disc")) {
    Section disc = section.Open("disc");
    return DiscGeometry{disc.Number("radius"), ReadThickness(disc)};
  }
  if (section.Has("polygon")) return ReadPolygon(section);
  if (section.Has("contour")) return ReadContourGeometry(section, context);
  Section rectangle = section.Open("rectangle");
  return RectangleGeometry{rectangle.Number("width"), rectangle.Number("height"),
                           ReadThickness(rectangle)};
}

Object ReadObject(Section& scene, const SceneContext& context) {
  Section section = scene.Open("object", "a map of geometry, material, fixed, ...");
  Object object;
  object.geometry = ReadGeometry(section, context);
  const auto at_origin = Eigen::Isometry3d::Identity();
  object.X_SO =
      IsPlanar(object.geometry) ? ReadPlanarPose(section, at_origin) : ReadPose(section, at_origin);
  object.material = ReadMaterial(section);
  object.regions = ReadRegions(section);
  object.fixed = ReadFixed(section, object.geometry);
  return object;
}

}  // namespace palpate
