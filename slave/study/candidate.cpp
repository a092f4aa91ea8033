#include "slave/study/candidate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "shared/mesh/boundary_patch.h"
#include "shared/mesh/disc_patch.h"
#include "slave/scene/model_kinds.h"

namespace palpate::study {
namespace {

using Eigen::Vector3d;

// Rough priors [s]; a study corrects them by what it measures. Dense: LU and inverse. Sparse:
// factors of three-dimensional meshes, times the solves of a trial.
double DenseSeconds(std::size_t dof) {
  const double n = static_cast<double>(dof);
  return 0.02 + 2e-7 * n * n + 1.5e-10 * n * n * n;
}
double SparseSeconds(std::size_t dof, double solves) {
  return 0.02 + 3e-8 * solves * std::pow(static_cast<double>(dof), 1.5);
}

double Perimeter(const BoundaryMesh& mesh) {
  double sum = 0;
  for (const BoundaryElement& e : mesh.elements) sum += e.length();
  return sum;
}

// --- planar objects
// Element counts for which whole numbers of elements lie under the tool, so that what is left of
// the error is the method's; coarser ones below, for who is in a hurry.
std::set<int> ElementCounts(const Scene& scene, const PressSpec& question) {
  constexpr int kFewest = 20, kMost = 1500;
  constexpr double kNearlyWhole = 2e-3;
  std::set<int> counts{scene.model.elements};
  if (HoldsByNumber(scene)) return counts;  // the numbers belong to this division
  Scene trial = scene;
  trial.model.elements = kMost;
  double per_tool = Perimeter(MeshOutline(trial, std::nullopt)) / question.width;
  if (std::abs(std::round(per_tool) / per_tool - 1) < kNearlyWhole) per_tool = std::round(per_tool);
  for (const int under_tool : {1, 2, 3, 5, 9, 15, 25, 45}) {
    const int wanted = static_cast<int>(std::lround(under_tool * per_tool));
    int best = 0;
    double smallest = std::numeric_limits<double>::infinity();
    const int slack = std::max(wanted / 40, 1);
    for (int n = wanted - slack; n <= wanted + slack; ++n) {
      if (n < kFewest || n > kMost) continue;
      trial.model.elements = n;
      const ObjectMesh mesh = MeshOutline(trial, std::nullopt);
      double mismatch = 0;
      for (std::size_t i = 0; i < question.presses.size(); i += question.presses.size() / 32 + 1) {
        Press press = question.presses[i];
        // Beside it, of many: a mesh chosen for the very places that judge it would be flattered.
        if (question.presses.size() > 2) press.p_O += 0.3 * question.width * press.along_O;
        mismatch =
            std::max(mismatch, std::abs(WidthMismatch(mesh, trial.model, press, question.width)));
      }
      mismatch += kNearlyWhole * std::abs(n - wanted);  // of equally good ones the nearest
      if (mismatch < smallest) best = n, smallest = mismatch;
    }
    if (best > 0) counts.insert(best);
  }
  for (const int n : {20, 30, 40}) counts.insert(n);
  for (int n = 60; counts.size() < 6 && n <= kMost; n *= 2) counts.insert(n);
  return counts;
}

std::string OrderName(ElementOrder order) {
  return order == ElementOrder::kConstant ? "constant"
         : order == ElementOrder::kLinear ? "linear"
                                          : "quadratic";
}

void AddPlanar(const Scene& scene, const PressSpec& question, const CandidateLimits& limits,
               std::vector<Candidate>* candidates) {
  for (const int n : ElementCounts(scene, question)) {
    for (const auto order :
         {ElementOrder::kConstant, ElementOrder::kLinear, ElementOrder::kQuadratic}) {
      Candidate c;
      c.scene = scene;
      c.scene.model.kind = "bem2d";
      c.scene.model.order = order;
      c.scene.model.elements = n;
      c.own = n == scene.model.elements;
      c.family = "bem2d " + OrderName(order);
      const BoundaryMesh mesh = MeshOutline(c.scene, std::nullopt);
      c.resolution = std::to_string(mesh.size()) + " elements";
      c.element_size = Perimeter(mesh) / mesh.size();
      c.dof = static_cast<std::size_t>(mesh.size()) * (order == ElementOrder::kQuadratic ? 4 : 2);
      c.expected_s = DenseSeconds(c.dof);
      if (c.dof <= limits.dense_dof || c.own) {
        candidates->push_back(std::move(c));
      }
    }
  }
}

// --- membranes
Candidate StartMembrane(const Scene& scene, const ModelKind& kind) {
  Candidate c;
  c.scene = scene;
  c.scene.model.kind = kind.name;
  c.family = c.scene.model.kind;
  c.resolution = "as in the scene";
  c.expected_s = 0.05;
  c.own = true;
  return c;
}

// Modes resolve what is about as wide as the radius by their number.
void AddModes(const Scene& scene, const ModelKind& kind, std::vector<Candidate>* candidates) {
  constexpr int kOwnChoice = 12;  // of the model
  const int own = scene.model.modes > 0 ? scene.model.modes : kOwnChoice;
  const double radius = std::get<MembraneGeometry>(scene.object.geometry).radius;
  for (const int modes : std::set<int>{own, 6, 8, 12, 16, 20}) {
    Candidate c = StartMembrane(scene, kind);
    c.scene.model.modes = modes == own ? scene.model.modes : modes;
    c.resolution = std::to_string(modes) + " modes";
    c.element_size = radius / modes;
    c.expected_s = 0.3 + 0.7 * std::pow(modes / 12.0, 4);
    c.own = modes == own;
    c.linear = false;
    candidates->push_back(std::move(c));
  }
}

void AddMembrane(const Scene& scene, std::vector<Candidate>* candidates) {
  for (const ModelKind& kind : kModelKinds) {
    if (kind.object != ObjectClass::kMembrane) continue;
    if (kind.linearity == Linearity::kNever) {
      AddModes(scene, kind, candidates);
    } else if (scene.model.prestress == 0) {
      candidates->push_back(StartMembrane(scene, kind));
    }
  }
}

// --- discs filled with a liquid
void AddShell(const Scene& scene, const CandidateLimits& limits,
              std::vector<Candidate>* candidates) {
  constexpr int kFewest = 320;  // that the model takes, see ShellModel
  const int own = std::max(scene.model.elements, kFewest);
  for (const int pieces : std::set<int>{own, kFewest, 448, 640, 1280}) {
    Candidate c;
    c.scene = scene;
    c.scene.model.kind = "shell";
    c.scene.model.elements = pieces;
    c.family = "shell";
    c.own = pieces == own;
    c.resolution = std::to_string(pieces) + " pieces";
    c.element_size = Perimeter(MeshOutline(c.scene, std::nullopt)) / pieces;
    c.expected_s = 1.0 * pieces / kFewest;  // Newton, for the rows of a table
    c.dof = 2 * static_cast<std::size_t>(pieces);
    c.linear = false;
    if (c.dof <= limits.dense_dof || c.own) candidates->push_back(std::move(c));
  }
}

// --- volumes
struct Division : Candidate {  // without a model
  bool between = false;  // for models that cannot afford the next one, to see how they converge
  std::size_t nodes = 0, tets = 0, skin = 0;  // expected; `skin`: surface triangles
};

std::string Times(const std::array<int, 3>& cells) {
  return std::to_string(cells[0]) + " x " + std::to_string(cells[1]) + " x " +
         std::to_string(cells[2]) + " cells";
}

std::vector<Division> BoxDivisions(const Scene& scene, const BoxGeometry& box) {
  std::vector<Division> divisions;
  std::set<std::array<int, 3>> seen;
  for (const double factor : {1.0, 0.5, 1.5, 2.0, 3.0, 4.0, 6.0}) {
    BoxGeometry scaled = box;
    for (int& n : scaled.cells) n = std::max(1, static_cast<int>(std::lround(n * factor)));
    if (!seen.insert(scaled.cells).second) continue;
    const auto [i, j, k] = scaled.cells;
    Division d;
    d.scene = scene;
    d.resolution = Times(scaled.cells);
    d.own = factor == 1;
    d.between = factor == 1.5;
    d.scene.object.geometry = scaled;
    const double cell = box.size.prod() / (1.0 * i * j * k);
    d.element_size = std::cbrt(cell);
    d.nodes = static_cast<std::size_t>(i + 1) * static_cast<std::size_t>(j + 1) *
              static_cast<std::size_t>(k + 1);
    d.tets =
        6 * static_cast<std::size_t>(i) * static_cast<std::size_t>(j) * static_cast<std::size_t>(k);
    d.skin = 4 * static_cast<std::size_t>(i * j + j * k + k * i);
    divisions.push_back(std::move(d));
  }
  return divisions;
}

double Volume(const SolidMesh& mesh) {
  double sum = 0;
  for (int t = 0; t < static_cast<int>(mesh.tets.size()); ++t) sum += SignedVolume(mesh, t);
  return sum;
}

// Nodes named one by one: those that refinement puts between two of them are held as well.
void HoldBetween(const SolidMesh& coarse, const SolidMesh& fine, std::vector<int>* nodes) {
  const std::set<int> held(nodes->begin(), nodes->end());
  const auto key = [](const Vector3d& p) { return std::array<double, 3>{p.x(), p.y(), p.z()}; };
  std::map<std::array<double, 3>, int> number;
  for (std::size_t i = coarse.nodes.size(); i < fine.nodes.size(); ++i) {
    number[key(fine.nodes[i])] = static_cast<int>(i);
  }
  std::set<int> more;
  for (const auto& tet : coarse.tets) {
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b < 4; ++b) {
        if (a == b || !held.contains(tet[a]) || !held.contains(tet[b])) continue;
        const Vector3d middle = 0.5 * (coarse.nodes[static_cast<std::size_t>(tet[a])] +
                                       coarse.nodes[static_cast<std::size_t>(tet[b])]);
        const auto found = number.find(key(middle));
        if (found != number.end()) more.insert(found->second);
      }
    }
  }
  nodes->insert(nodes->end(), more.begin(), more.end());
}

// The supports of `scene` on its mesh refined once more; `mesh` becomes that mesh.
void RefineSupports(SolidMesh* mesh, Scene* scene) {
  SolidMesh fine = Refined(*mesh);
  for (Fixed& fixed : scene->object.fixed) {
    if (auto* listed = std::get_if<FixedNodes>(&fixed.where)) {
      HoldBetween(*mesh, fine, &listed->nodes);
    }
  }
  *mesh = std::move(fine);
}

std::vector<Division> FileDivisions(const Scene& scene, std::size_t most_dof) {
  std::vector<Division> divisions;
  const ObjectMesh mesh = MeshObject(scene, std::nullopt);
  const auto* solid = std::get_if<SolidMesh>(&mesh);
  SolidMesh refined = solid ? *solid : SolidMesh{};
  Scene supported = scene;
  const SurfaceMesh skin = solid ? SurfaceOf(*solid) : std::get<SurfaceMesh>(mesh);
  for (int r = 0; r <= 2; ++r) {
    if (r > 0 && HoldsByNumber(scene)) {
      if (!solid || 24 * refined.nodes.size() > most_dof) break;
      RefineSupports(&refined, &supported);
    }
    Division d;
    d.scene = supported;
    d.own = r == 0;
    d.scene.model.refinements = r;
    const auto eights = static_cast<std::size_t>(1) << (3 * r);
    d.tets = solid ? solid->tets.size() * eights : 0;
    d.nodes = (solid ? solid->nodes.size() : 0) * eights;
    d.skin = skin.triangles.size() << (2 * r);
    const double cell = solid ? 6 * Volume(*solid) / static_cast<double>(d.tets) : 0;
    double area = 0;
    for (int t = 0; t < static_cast<int>(skin.triangles.size()); ++t) area += Area(skin, t);
    d.element_size = solid ? std::cbrt(cell) : std::sqrt(2 * area / static_cast<double>(d.skin));
    d.resolution = std::to_string(solid ? d.tets : d.skin) + (solid ? " tets" : " triangles");
    divisions.push_back(std::move(d));
  }
  return divisions;
}

Candidate Start(const Division& d, std::string kind, std::string family) {
  Candidate c = d;
  c.scene.model.kind = std::move(kind);
  c.family = std::move(family);
  return c;
}

void AddFem(const Division& d, FemOptions::Element element, FemOptions::Law law, double residual,
            const CandidateLimits& limits, std::vector<Candidate>* candidates) {
  const bool quadratic = element == FemOptions::Element::kTet10;
  const bool hyperelastic = IsHyperelastic(law);
  const bool linear = law == FemOptions::Law::kLinear;
  Candidate c = Start(d, hyperelastic ? "fem-hyperelastic" : "fem",
                      std::string(hyperelastic ? "fem-hyperelastic " : "fem ") +
                          (quadratic ? "tet10" : "tet4") +
                          (hyperelastic ? ""
                           : linear     ? " linear"
                                        : " corotational"));
  c.scene.model.fem.element = element;
  c.scene.model.fem.law = law;
  c.scene.model.fem.time = FemOptions::Time::kStatic;
  c.scene.model.fem.residual = residual;
  c.dof = 3 * d.nodes * (quadratic ? 8 : 1);
  c.linear = linear;
  const double digits = -std::log10(residual);
  c.expected_s = SparseSeconds(c.dof, linear ? 3 : hyperelastic ? 10 * digits : 5 * digits);
  if (c.dof <= limits.dof) candidates->push_back(std::move(c));
}

// Of quadratic tetrahedra its contacts touch the corners alone, between which the surface gives
// way: no accuracy is gained, so they are left out.
void AddGreen(const Division& d, const CandidateLimits& limits,
              std::vector<Candidate>* candidates) {
  Candidate c = Start(d, "fem-green", "fem-green");
  c.scene.model.fem.element = FemOptions::Element::kTet4;
  c.dof = 3 * d.nodes;
  c.expected_s = SparseSeconds(c.dof, 10);
  if (c.dof <= limits.dof) candidates->push_back(std::move(c));
}

void AddVolume(const Division& d, const CandidateLimits& limits,
               std::vector<Candidate>* candidates) {
  using Element = FemOptions::Element;
  using Law = FemOptions::Law;
  const double own = d.scene.model.fem.residual;
  // The scene's own law of large strains, if it names one.
  const Law large =
      IsHyperelastic(d.scene.model.fem.law) ? d.scene.model.fem.law : Law::kNeoHookean;
  std::set<double> residuals{own};
  if (limits.residuals) residuals = {1e-3, 1e-6, 1e-9};
  if (d.tets > 0) {
    AddFem(d, Element::kTet10, Law::kLinear, own, limits, candidates);
    AddGreen(d, limits, candidates);
  }
  if (d.tets > 0 && !d.between) {
    AddFem(d, Element::kTet4, Law::kLinear, own, limits, candidates);
    AddFem(d, Element::kTet10, large, own, limits, candidates);
    for (const double residual : residuals) {
      AddFem(d, Element::kTet4, Law::kCorotational, residual, limits, candidates);
      AddFem(d, Element::kTet4, large, residual, limits, candidates);
    }
  }
  Candidate bem = Start(d, "bem3d", "bem3d");
  bem.dof = 3 * d.skin;
  bem.expected_s = 5 * DenseSeconds(bem.dof);
  if (bem.dof <= limits.dense_dof) candidates->push_back(std::move(bem));
}

double PatchLength(const BoundaryMesh& mesh, const Press& press, double width) {
  const Eigen::Vector2d p = press.p_O.head<2>();
  const int element = FindElement(mesh, p);
  double length = 0;
  for (const int i : PatchElements(mesh, element, p, width)) {
    length += mesh.elements[static_cast<std::size_t>(i)].length();
  }
  return length;
}

double Diameter(double area) {
  return 2 * std::sqrt(area / std::numbers::pi);
}

// Nodes count with a third of the area of the triangles around them.
double NodesDiameter(const SurfaceMesh& surface, const Press& press, double width) {
  const auto place = FindPlace(surface, press.p_O);
  if (!place) return kUnknown;
  const DiscPatch patch = PatchAt(surface, *place, press.p_O, width);
  const std::set<int> nodes(patch.nodes.begin(), patch.nodes.end());
  double area = 0;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    const auto& corners = surface.triangles[static_cast<std::size_t>(t)];
    const auto in_patch = std::ranges::count_if(corners, [&](int n) { return nodes.contains(n); });
    if (in_patch == 0 || Normal(surface, t).dot(press.inward_O) > -0.5) continue;
    area += Area(surface, t) * static_cast<double>(in_patch) / 3;
  }
  return Diameter(area);
}

double TrianglesDiameter(const SurfaceMesh& surface, const Press& press, double width) {
  const auto place = FindPlace(surface, press.p_O);
  if (!place) return kUnknown;
  double area = 0;
  for (const int t : PatchAt(surface, *place, press.p_O, width).triangles) area += Area(surface, t);
  return Diameter(area);
}

}  // namespace

std::vector<Candidate> CandidatesFor(const Scene& scene, const PressSpec& question,
                                     const CandidateLimits& limits) {
  std::vector<Candidate> candidates;
  const Geometry& geometry = scene.object.geometry;
  if (std::holds_alternative<MembraneGeometry>(geometry)) {
    AddMembrane(scene, &candidates);
  } else if (scene.model.wall > 0) {
    AddShell(scene, limits, &candidates);
  } else if (IsPlanar(geometry)) {
    AddPlanar(scene, question, limits, &candidates);
  } else {
    const auto* box = std::get_if<BoxGeometry>(&geometry);
    const bool by_cells = box != nullptr && !HoldsByNumber(scene);
    for (const Division& d :
         by_cells ? BoxDivisions(scene, *box) : FileDivisions(scene, limits.dof)) {
      AddVolume(d, limits, &candidates);
    }
  }
  if (!limits.families.empty()) {
    std::erase_if(candidates, [&](const Candidate& c) {
      return std::ranges::find(limits.families, c.family) == limits.families.end();
    });
  }
  std::ranges::stable_sort(candidates, {}, &Candidate::expected_s);
  return candidates;
}

bool HoldsByNumber(const Scene& scene) {
  return std::ranges::any_of(scene.object.fixed, [](const Fixed& fixed) {
    return std::holds_alternative<FixedNodes>(fixed.where);
  });
}

bool HasMidnodes(const ModelOptions& model) {
  const ModelKind* kind = FindModelKind(model.kind);
  return kind != nullptr && kind->has_tets && model.fem.element == FemOptions::Element::kTet10;
}

bool TakesWidthAsItIs(const ObjectMesh& mesh, const ModelOptions& model) {
  return std::holds_alternative<MembraneDisc>(mesh) || model.wall > 0;
}

double WidthMismatch(const ObjectMesh& mesh, const ModelOptions& model, const Press& press,
                     double width) {
  if (TakesWidthAsItIs(mesh, model)) return 0;
  double seen = 0;
  if (const auto* boundary = std::get_if<BoundaryMesh>(&mesh)) {
    seen = PatchLength(*boundary, press, width);
  } else {
    const auto* solid = std::get_if<SolidMesh>(&mesh);
    SurfaceMesh skin = solid ? SurfaceOf(*solid) : std::get<SurfaceMesh>(mesh);
    const ModelKind* kind = FindModelKind(model.kind);
    if (kind != nullptr && kind->on_surface) {
      seen = TrianglesDiameter(skin, press, width);
    } else {
      seen = NodesDiameter(HasMidnodes(model) ? Refined(skin) : skin, press, width);
    }
  }
  return seen > 0 ? seen / width - 1 : kUnknown;
}

}  // namespace palpate::study
