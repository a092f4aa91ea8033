#include "slave/study/candidate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "slave/mechanics/factory/make_model.h"
#include "slave/mesh/boundary_patch.h"
#include "slave/mesh/index.h"
#include "slave/scene/model_kinds.h"
#include "slave/study/mesh_division.h"

namespace palpate::study {
namespace {

// Rough estimates of times [s]; a study corrects them by measured ones. Dense: LU and inverse.
// Sparse: solutions on three-dimensional meshes for the precomputation and for all presses.
// [measured: boxes of 100 to 32,000 degrees of freedom, 29 presses each]
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

Candidate Start(const Scene& scene, std::string kind, std::string family) {
  Candidate c;
  c.scene = scene;
  c.scene.object.material.relaxation.clear();  // a study solves presses without relaxation
  c.scene.model.kind = std::move(kind);
  c.family = std::move(family);
  return c;
}

// The scene's own model at its own resolution.
bool IsOwn(const Scene& scene, const Candidate& c) {
  return c.own && IsSameModel(scene.model, c.scene.model);
}

// --- planar objects

// Difference of the width of the whole elements under the tool from the tool's own [-].
double WidthMismatch(const BoundaryMesh& mesh, const Press& press, double width) {
  const Eigen::Vector2d p = press.p_O.head<2>();
  double length = 0;
  for (const int i : PatchElements(mesh, FindElement(mesh, p), p, width)) {
    length += mesh.elements[Index(i)].length();
  }
  return length > 0 ? length / width - 1 : kUnknown;
}

// Element counts for which a whole number of elements is under the tool, so that
// the remaining error is that of the method; and coarser ones for speed.
std::set<int> ElementCounts(const Scene& scene, const PressSpec& question) {
  constexpr int kMinElements = 20, kMaxElements = 1500;
  constexpr double kNearlyWhole = 2e-3;
  std::set<int> counts{scene.model.elements};
  if (HoldsByNumber(scene)) return counts;  // the numbers belong to this division
  Scene trial = scene;
  trial.model.elements = kMaxElements;
  double per_tool = Perimeter(MeshOutline(trial, std::nullopt)) / question.width;
  if (std::abs(std::round(per_tool) / per_tool - 1) < kNearlyWhole) per_tool = std::round(per_tool);
  for (const int under_tool : {1, 2, 3, 5, 9, 15, 25, 45}) {
    const int wanted = static_cast<int>(std::lround(under_tool * per_tool));
    int best = 0;
    double smallest = std::numeric_limits<double>::infinity();
    const int slack = std::max(wanted / 40, 1);
    for (int n = wanted - slack; n <= wanted + slack; ++n) {
      if (n < kMinElements || n > kMaxElements) continue;
      trial.model.elements = n;
      const BoundaryMesh mesh = MeshOutline(trial, std::nullopt);
      double mismatch = 0;
      for (std::size_t i = 0; i < question.presses.size(); i += question.presses.size() / 32 + 1) {
        Press press = question.presses[i];
        // With many presses the mesh is independent of them, because a mesh that fits the tested
        // positions exactly would seem too accurate.
        if (question.presses.size() > 2) press.p_O += 0.3 * question.width * press.along_O;
        mismatch = std::max(mismatch, std::abs(WidthMismatch(mesh, press, question.width)));
      }
      mismatch += kNearlyWhole * std::abs(n - wanted);  // prefers the nearest of equally good ones
      if (mismatch < smallest) best = n, smallest = mismatch;
    }
    if (best > 0) counts.insert(best);
  }
  for (const int n : {20, 30, 40}) counts.insert(n);
  for (int n = 60; counts.size() < 6 && n <= kMaxElements; n *= 2) counts.insert(n);
  return counts;
}

std::string OrderName(ElementOrder order) {
  return order == ElementOrder::kConstant ? "constant"
         : order == ElementOrder::kLinear ? "linear"
                                          : "quadratic";
}

// Adds one candidate, because its mesh is made for the tool. [measured: a second for each of three
// places]
void AddExtruded(const Scene& scene, std::vector<Candidate>* candidates) {
  Candidate c = Start(scene, "extruded", "extruded");
  c.resolution = "as the tool needs";
  c.element_size = scene.tool->width;
  c.expected_s = 3;
  c.own = true;
  candidates->push_back(std::move(c));
}

void AddPlanar(const Scene& scene, const PressSpec& question, const CandidateLimits& limits,
               std::vector<Candidate>* candidates) {
  if (AcceptsExtruded(scene)) AddExtruded(scene, candidates);
  for (const int n : ElementCounts(scene, question)) {
    for (const auto order :
         {ElementOrder::kConstant, ElementOrder::kLinear, ElementOrder::kQuadratic}) {
      Candidate c = Start(scene, "bem2d", "bem2d " + OrderName(order));
      c.scene.model.order = order;
      c.scene.model.elements = n;
      c.own = n == scene.model.elements;
      const BoundaryMesh mesh = MeshOutline(c.scene, std::nullopt);
      c.resolution = std::to_string(mesh.size()) + " elements";
      c.element_size = Perimeter(mesh) / mesh.size();
      c.dof = Index(mesh.size()) * (order == ElementOrder::kQuadratic ? 4 : 2);
      c.expected_s = DenseSeconds(c.dof);
      if (c.dof <= limits.dense_dof || c.own) candidates->push_back(std::move(c));
    }
  }
}

// --- membranes
Candidate StartMembrane(const Scene& scene, const ModelKind& kind) {
  Candidate c = Start(scene, std::string(kind.name), std::string(kind.name));
  c.resolution = "as in the scene";
  c.expected_s = 0.05;
  c.own = true;
  return c;
}

// The resolution of modes is about the radius divided by their number.
void AddModes(const Scene& scene, const ModelKind& kind, std::vector<Candidate>* candidates) {
  constexpr int kOwnChoice = 12;  // number of modes that the model chooses
  const int own = scene.model.modes > 0 ? scene.model.modes : kOwnChoice;
  const double radius = std::get<MembraneGeometry>(scene.object.geometry).radius;
  for (const int modes : std::set<int>{own, 6, 8, 12, 16, 20}) {
    Candidate c = StartMembrane(scene, kind);
    c.scene.model.modes = modes == own ? scene.model.modes : modes;
    c.resolution = std::to_string(modes) + " modes";
    c.element_size = radius / modes;
    c.expected_s = 0.3 + 0.7 * std::pow(modes / 12.0, 4);
    c.own = modes == own;
    c.selectable = c.own;
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

// --- volumes
Candidate Start(const Division& d, std::string kind, std::string family) {
  Candidate c = Start(d.scene, std::move(kind), std::move(family));
  c.resolution = d.resolution;
  c.element_size = d.element_size;
  c.own = d.own;
  return c;
}

const char* NameOf(FemOptions::Law law) {
  constexpr std::array kNames{"corotational", "linear", "neo-hookean", "ogden"};
  return kNames[static_cast<std::size_t>(law)];
}

// Solves of one press, in the unit of SparseSeconds; iterations grow with the digits requested.
double SolvesOfAPress(bool quadratic, FemOptions::Law law, double residual) {
  const double digits = -std::log10(residual);
  if (law == FemOptions::Law::kLinear) return 5;
  if (!IsHyperelastic(law)) return 5 * digits;
  return (quadratic ? 6 : 3.5) * digits;
}

void AddFem(const Division& d, FemOptions::Element element, FemOptions::Law law, double residual,
            const CandidateLimits& limits, std::vector<Candidate>* candidates) {
  const bool quadratic = element == FemOptions::Element::kTet10;
  Candidate c =
      Start(d, "fem", std::string("fem ") + (quadratic ? "tet10 " : "tet4 ") + NameOf(law));
  c.scene.model.fem.element = element;
  c.scene.model.fem.law = law;
  c.scene.model.fem.time = FemOptions::Time::kStatic;
  c.scene.model.fem.residual = residual;
  c.dof = 3 * d.nodes * (quadratic ? 8 : 1);
  c.linear = law == FemOptions::Law::kLinear;
  c.expected_s = SparseSeconds(c.dof, d.presses * SolvesOfAPress(quadratic, law, residual));
  if (c.dof <= limits.dof) candidates->push_back(std::move(c));
}

void AddGreen(const Division& d, FemOptions::Element element, const CandidateLimits& limits,
              std::vector<Candidate>* candidates) {
  const bool quadratic = element == FemOptions::Element::kTet10;
  Candidate c = Start(d, "fem-green", quadratic ? "fem-green tet10" : "fem-green");
  c.scene.model.fem.element = element;
  c.dof = 3 * d.nodes * (quadratic ? 8 : 1);
  c.expected_s = SparseSeconds(c.dof, (quadratic ? 20 : 10) + 1.4 * d.presses);
  if (c.dof <= limits.dof) candidates->push_back(std::move(c));
}

// Adds the model that the scene names if no row above has it, such as corotational ten-node
// tetrahedra.
void AddOwn(const Division& d, std::vector<Candidate>* candidates) {
  const ModelOptions& own = d.scene.model;
  const ModelKind* kind = FindModelKind(own.kind);
  if (!d.own || kind == nullptr || kind->object != ObjectClass::kVolume) return;
  if (std::ranges::any_of(*candidates, [&](const Candidate& c) { return IsOwn(d.scene, c); })) {
    return;
  }
  if (kind->iterates) {
    const std::size_t any = std::numeric_limits<std::size_t>::max();
    return AddFem(d, own.fem.element, own.fem.law, own.fem.residual, {.dof = any}, candidates);
  }
  Candidate c = Start(d, own.kind, own.kind);
  c.dof = 3 * d.nodes;
  c.expected_s = SparseSeconds(c.dof, 10);
  candidates->push_back(std::move(c));
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
  AddFem(d, Element::kTet10, Law::kLinear, own, limits, candidates);
  AddGreen(d, Element::kTet4, limits, candidates);
  AddGreen(d, Element::kTet10, limits, candidates);
  if (!d.between) {
    AddFem(d, Element::kTet4, Law::kLinear, own, limits, candidates);
    AddFem(d, Element::kTet10, large, own, limits, candidates);
    for (const double residual : residuals) {
      AddFem(d, Element::kTet4, Law::kCorotational, residual, limits, candidates);
      AddFem(d, Element::kTet4, large, residual, limits, candidates);
    }
  }
  AddOwn(d, candidates);
}

}  // namespace

bool IsSameModel(const ModelOptions& a, const ModelOptions& b) {
  return a.kind == b.kind && a.order == b.order && a.fem.element == b.fem.element &&
         a.fem.law == b.fem.law && a.fem.residual == b.fem.residual;
}

std::vector<Candidate> CandidatesFor(const Scene& scene, const PressSpec& question,
                                     const CandidateLimits& limits) {
  std::vector<Candidate> candidates;
  const Geometry& geometry = scene.object.geometry;
  if (std::holds_alternative<MembraneGeometry>(geometry)) {
    AddMembrane(scene, &candidates);
  } else if (IsPlanar(geometry)) {
    AddPlanar(scene, question, limits, &candidates);
  } else {
    for (Division& d : DivisionsOf(scene, limits.dof)) {
      d.presses = static_cast<double>(question.presses.size());
      AddVolume(d, limits, &candidates);
    }
  }
  // Contacts that another model cannot solve are not compared with it.
  const bool is_usual = !scene.tool || scene.tool->shape == Tool::Shape::kFlat ||
                        scene.tool->shape == Tool::Shape::kRound;
  if (!is_usual || scene.model.contact == ContactLaw::kFriction) {
    std::erase_if(candidates, [](const Candidate& c) { return !FollowsTools(c.scene.model); });
  }
  if (!limits.families.empty()) {
    std::erase_if(candidates, [&](const Candidate& c) {
      return std::ranges::find(limits.families, c.family) == limits.families.end();
    });
  }
  std::erase_if(candidates, [&](const Candidate& c) {
    const bool large = limits.large && c.own && IsLargeDeformation(c.scene.model);
    return limits.own && !large && !IsOwn(scene, c);
  });
  for (Candidate& c : candidates) c.own_model = IsOwn(scene, c);
  std::ranges::stable_sort(candidates, {}, &Candidate::expected_s);
  for (std::size_t i = 0; i < candidates.size(); ++i) candidates[i].number = i;
  return candidates;
}

}  // namespace palpate::study
