#include "slave/mechanics/factory/choose_model.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include <Eigen/Geometry>

#include "shared/text/text.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/factory/tool_domain.h"
#include "slave/mechanics/mesh_resolution.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/mesh/index.h"
#include "slave/scene/model_kinds.h"

namespace palpate {
namespace {

double Percent(double share) {
  return 100 * share;
}

// --- outlines

// Error of constant elements times their number under the tool [-]: kElementError +
// kElementErrorOfWidth (tool's width / larger side). [measured: study of 36 drawn outlines: the 95
// % bound over 128 places is below it on nine of ten]
constexpr double kElementError = 0.13, kElementErrorOfWidth = 1.6;
constexpr double kMinUnderTool = 2;
constexpr double kMinElements = 40;  // of an outline
// Unknowns of a dense inverse, four for each linear element and two for each constant one [-].
// [measured: 2000 take a second]
constexpr int kMaxDenseDof = 2000;
// Larger side relative to 2 A / P from which an outline may bend, which constant elements resist
// (bem/element_error.h).
constexpr double kSlenderOutline = 2.5;

std::string PlaneWords(const Scene& scene, double error) {
  const char* plane = scene.model.plane == Plane::kStress ? "plane stress" : "plane strain";
  if (!std::isfinite(error)) return std::string(plane) + " (tool.depth is not set)";
  return plane + Formatted(" is off by up to %.2g %% under this tool", Percent(error));
}

ModelChoice ChooseOutline(const Scene& scene) {
  ModelChoice choice{.model = scene.model};
  choice.model.kind = "bem2d";
  if (std::holds_alternative<ImageContourGeometry>(scene.object.geometry)) {
    choice.reason = "outline that only the image shows: plane boundary elements";
    return choice;
  }
  if (!scene.tool) {
    choice.reason = "outline without a tool: plane boundary elements";
    return choice;
  }
  const BoundaryMesh mesh = MeshOutline(scene, std::nullopt);
  Scene plane = scene, extruded = scene;
  plane.model.kind = "bem2d";
  extruded.model.kind = "extruded";
  const double tolerance = scene.model.tolerance, error = PlaneError(plane, *scene.tool, mesh);
  choice.reason = PlaneWords(scene, error);
  if (error > tolerance && AcceptsExtruded(scene) &&
      PlaneError(extruded, *scene.tool, mesh) < error) {
    choice.model.kind = "extruded";
    choice.reason += Formatted(", beyond the tolerance of %.3g %%", Percent(tolerance));
    return choice;
  }
  if (HoldsByNumber(scene)) return choice;
  const OutlineSize size = SizeOfOutline(mesh);
  const bool bends = size.sides.maxCoeff() * size.perimeter > 2 * kSlenderOutline * size.area;
  choice.model.order = bends ? ElementOrder::kLinear : ElementOrder::kConstant;
  const double left = error < tolerance ? tolerance - error : tolerance;
  const double width = TouchedWidth(*scene.tool), per_tool = size.perimeter / width;
  const double error_of_one = kElementError + kElementErrorOfWidth * width / size.sides.maxCoeff();
  const double wanted = std::max(std::ceil(error_of_one / left), kMinUnderTool) * per_tool;
  const double most = kMaxDenseDof / (bends ? 4.0 : 2.0);
  choice.model.elements = static_cast<int>(std::lround(std::clamp(wanted, kMinElements, most)));
  choice.reason += Formatted("; %.2g elements under the tool", choice.model.elements / per_tool);
  return choice;
}

// --- membranes

// Largest deflection of a plate that bends only [thicknesses]: paper C.
constexpr double kThin = 0.5;

// Returns the relative error of a plate without stretching at the central deflection w
// [thicknesses]: the force of von Karman's plate is 1 + c w^2 times as large. c is fitted to the
// clamped plate of `plate-large`: 1.8 % at 0.2, 10 % at 0.5, 30 % at 1; beyond, it is too large.
double LackOfStretching(double w) {
  constexpr double c = 0.45;
  return 1 - 1 / (1 + c * w * w);
}

// Bending without stretching if the press is within its range and tolerance. A scene without a
// stated press may get any load.
ModelChoice ChoosePlate(const Scene& scene, double thickness) {
  const auto choose = [&](bool bends_only, const std::string& why) {
    ModelChoice choice{.model = scene.model};
    choice.model.kind = bends_only ? "plate" : "plate-large";
    choice.reason =
        why + (bends_only ? "the clamped plate's closed form" : "bending and stretching");
    return choice;
  };
  const OperatorOptions& hand = scene.operator_options;
  if (scene.model.prestress > 0) return choose(false, "membrane under tension at rest: ");
  if (!hand.press_given && !HasStereoOrDepth(scene.sense)) return choose(true, "membrane: ");
  const double w = hand.press_depth / thickness, lack = LackOfStretching(w);
  const std::string why =
      Formatted(
          "membrane: an indentation of %.2g thicknesses, where the force of bending alone is ", w) +
      (w <= 1 ? Formatted("%.2g %% too low: ", Percent(lack)) : "far too low: ");
  return choose(w <= kThin && lack <= scene.model.tolerance, why);
}

// --- volumes

// Error of a linear model's force relative to a neo-Hookean body, by the depth relative to the
// body's height [-]. [measured: study of 24 drawn boxes and domes]
constexpr double kErrorOfDepth = 0.7;
// Share of the tolerance that this error may take [-].
constexpr double kLinearShare = 0.7;
// Error of tetrahedra times the number of their edges under the tool [-], and the fewest of these
// edges: with fewer most places are flagged as too coarse. [measured: the same study]
constexpr double kTetError = 0.4, kMinEdges4 = 3.2, kMinEdges10 = 3.6;
// Unknowns of a sparse factorisation that takes some seconds [-], and those of a model that solves
// while it runs.
constexpr double kMaxSparseDof = 30'000, kMaxLiveDof = 10'000;

struct Body {
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // of its bounding box [m]
  double volume = 0;                               // [m^3]
  std::size_t tets = 0;                            // 0: a surface, which is filled later
};

Body BodyOf(const Geometry& geometry) {
  if (const auto* box = std::get_if<BoxGeometry>(&geometry)) {
    return {box->size, box->size.prod(),
            6 * Index(box->cells[0]) * Index(box->cells[1]) * Index(box->cells[2])};
  }
  const MeshFile file = ReadMesh(std::get<MeshFileGeometry>(geometry));
  Body body;
  Eigen::AlignedBox3d around;
  const auto& nodes = std::visit(
      [](const auto& mesh) -> const auto& { return mesh.nodes; }, file.mesh);
  for (const Eigen::Vector3d& p_O : nodes) around.extend(p_O);
  if (!around.isEmpty()) body.size = around.sizes();
  if (const auto* solid = std::get_if<SolidMesh>(&file.mesh)) {
    body.tets = solid->tets.size();
    for (int t = 0; t < static_cast<int>(body.tets); ++t)
      body.volume += std::abs(SignedVolume(*solid, t));
  }
  return body;
}

// Returns why only `fem` computes the scene; empty: others do, too.
std::string OnlyFem(const Scene& scene) {
  const FemOptions& fem = scene.model.fem;
  if (fem.time == FemOptions::Time::kDynamic) return "it moves in time";
  if (!fem.gravity_O.isZero(0)) return "it has a weight";
  if (!fem.is_law_default && IsHyperelastic(fem.law)) return "its law is for large strains";
  if (scene.model.contact == ContactLaw::kFriction) return "its contact has friction";
  if (!scene.tool) return {};
  const Tool::Shape shape = scene.tool->shape;
  const bool is_usual = shape == Tool::Shape::kFlat || shape == Tool::Shape::kRound;
  return is_usual ? std::string() : "its tool is a " + std::string(WordOf(shape));
}

// The number of tetrahedra's edges under the tool.
double EdgesUnder(double width, const Body& body) {
  return body.tets == 0 ? 0 : width / std::cbrt(6 * body.volume / static_cast<double>(body.tets));
}

// Unknowns of a mesh with this many tetrahedra, whose nodes are a sixth of them.
double DofOf(double tets, bool quadratic) {
  return 3 * tets / 6 * (quadratic ? 8 : 1);
}

// Gives the model the element and the division that the tolerance needs.
void ChooseMesh(const Scene& scene, const Body& body, double width, double left,
                ModelChoice* choice) {
  const FemOptions& own = scene.model.fem;
  const bool is_ogden = own.law == FemOptions::Law::kOgden;
  const bool moves = own.time == FemOptions::Time::kDynamic;
  const bool is_linear = choice->model.kind == "fem-green";
  const double max_dof = is_linear ? kMaxSparseDof : kMaxLiveDof;
  const bool follows = ShapesTool(choice->model, *scene.tool);
  const double edges = EdgesUnder(width, body);
  const auto tets_for = [&](double min_edges) {
    const double wanted = std::max(kTetError / left, min_edges);
    return static_cast<double>(body.tets) * std::pow(wanted / edges, 3);
  };
  const bool locks = scene.object.material.poisson_ratio >= kLocksAtPoint;
  // Ten nodes cost a linear model no time at runtime, and a Newton step ten times as much.
  bool quadratic = locks || is_ogden;
  if (is_linear) quadratic = locks || DofOf(tets_for(kMinEdges10), true) < max_dof;
  if (follows || moves) quadratic = own.element == FemOptions::Element::kTet10;
  choice->model.fem.element = quadratic ? FemOptions::Element::kTet10 : FemOptions::Element::kTet4;
  choice->reason += quadratic ? "; ten-node tetrahedra" : "; four-node tetrahedra";
  if (HoldsByNumber(scene) || body.tets == 0) return;
  const double most = 6 * max_dof / (3 * (quadratic ? 8 : 1));
  const double tets = std::min(tets_for(quadratic ? kMinEdges10 : kMinEdges4), most);
  const double finer = std::cbrt(tets / static_cast<double>(body.tets));
  if (const auto* box = std::get_if<BoxGeometry>(&scene.object.geometry)) {
    const double edge = std::cbrt(6 * body.volume / tets);
    for (std::size_t k = 0; k < 3; ++k) {
      choice->cells[k] = std::max(
          2, static_cast<int>(std::lround(box->size[static_cast<Eigen::Index>(k)] / edge)));
    }
    choice->reason +=
        Formatted(", %d x %d x %d cells", choice->cells[0], choice->cells[1], choice->cells[2]);
  } else {
    choice->model.refinements = std::clamp(static_cast<int>(std::lround(std::log2(finer))), 0, 2);
    const int halved = choice->model.refinements;
    if (halved > 0) choice->reason += halved == 1 ? ", edges halved once" : ", edges halved twice";
  }
}

ModelChoice ChooseVolume(const Scene& scene) {
  ModelChoice choice{.model = scene.model};
  const std::string only = OnlyFem(scene);
  const Body body = BodyOf(scene.object.geometry);
  const double strain = scene.operator_options.press_depth / body.size.minCoeff();
  const double tolerance = scene.model.tolerance;
  const double of_depth = kErrorOfDepth * strain;
  const bool relaxes = !scene.object.material.relaxation.empty();
  const bool is_deep =
      only.empty() && !relaxes && (of_depth > kLinearShare * tolerance || strain > kDeepest);
  const bool is_linear = only.empty() && !is_deep;
  choice.model.kind = is_linear ? "fem-green" : "fem";
  if (is_deep) choice.model.fem.law = FemOptions::Law::kNeoHookean;
  choice.reason = !only.empty() ? "volume, and " + only
                  : relaxes
                      ? std::string("volume whose moduli fade")
                      : Formatted("volume, pressed by %.2g %% of its height", Percent(strain));
  choice.reason += is_deep ? ": large strains" : is_linear ? ": linear" : "";
  const double width = scene.tool ? TouchedWidth(*scene.tool) : 0;
  if (width == 0) return choice;
  const double left = is_linear && of_depth < tolerance ? tolerance - of_depth : tolerance;
  ChooseMesh(scene, body, width, left, &choice);
  return choice;
}

}  // namespace

ModelChoice ChooseModel(const Scene& scene) {
  if (scene.model.kind != "auto") {
    const std::string& reason = scene.model.reason;
    return {.model = scene.model, .reason = reason.empty() ? "set by model.kind" : reason};
  }
  const Geometry& geometry = scene.object.geometry;
  ModelChoice choice;
  if (const auto* membrane = std::get_if<MembraneGeometry>(&geometry)) {
    choice = ChoosePlate(scene, membrane->thickness);
  } else if (std::holds_alternative<DomeGeometry>(geometry)) {
    choice.model = scene.model;
    choice.model.kind = "membrane";
    choice.reason = "air-filled membrane: a membrane under tension, linear about its rest shape";
  } else {
    choice = IsVolume(geometry) ? ChooseVolume(scene) : ChooseOutline(scene);
  }
  choice.reason = "auto: " + choice.reason;
  choice.model.reason = choice.reason;
  return choice;
}

Scene WithChosenModel(Scene scene) {
  if (scene.model.kind != "auto") return scene;
  ModelChoice choice = ChooseModel(scene);
  auto* box = std::get_if<BoxGeometry>(&scene.object.geometry);
  if (box != nullptr && choice.cells[0] > 0) box->cells = choice.cells;
  scene.model = std::move(choice.model);
  return scene;
}

}  // namespace palpate
