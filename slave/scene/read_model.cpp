#include <array>
#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "slave/scene/model_kinds.h"
#include "slave/scene/sections.h"

namespace palpate {
namespace {

using Fem = FemOptions;

void ReadPlanar(Section& model, const ModelKind& kind, ModelOptions* options) {
  options->elements = model.Integer("elements");
  if (!kind.is_plane) return;
  options->order = model.OneOf<ElementOrder>("order", {{"constant", ElementOrder::kConstant},
                                                       {"linear", ElementOrder::kLinear},
                                                       {"quadratic", ElementOrder::kQuadratic}});
  options->plane =
      model.OneOf<Plane>("plane", {{"stress", Plane::kStress}, {"strain", Plane::kStrain}});
}

void ReadMotion(Section& model, Fem* fem) {
  fem->time = model.OneOf<Fem::Time>(
      "time", {{"static", Fem::Time::kStatic}, {"dynamic", Fem::Time::kDynamic}});
  fem->step = model.Number("step");
}

void ReadElement(Section& model, Fem* fem) {
  fem->element = model.OneOf<Fem::Element>(
      "element", {{"tet4", Fem::Element::kTet4}, {"tet10", Fem::Element::kTet10}});
}

// Shares of the shear modulus at rest with their exponents. None is negative: such a law is stable
// under every load.
std::vector<OgdenTerm> ReadTerms(Section& model) {
  Section list = model.OpenList("terms", "a list of [share, exponent], for law: ogden");
  std::vector<OgdenTerm> terms;
  double sum = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::array rules{Rule{Dimension::kNumber, 0, 1, "a share (0 to 1)"},
                           Rule{Dimension::kNumber, -50, 50, "an exponent (-50 to 50)"}};
    const auto term = list.Numbers(std::to_string(i), rules);
    if (term.size() != 2) continue;  // a mistake that is reported already
    if (std::abs(term[1]) < 1e-3) list.Refuse(std::to_string(i), "an exponent that is not zero");
    terms.push_back({term[0], term[1]});
    sum += term[0];
  }
  const bool adds_up = std::abs(sum - 1) < 1e-3 && terms.size() <= 6;
  if (list.present() && !adds_up) {
    model.Refuse("terms", "one to six terms whose shares add up to 1");
    return {};
  }
  for (OgdenTerm& term : terms) term.share /= sum;
  return terms;
}

void ReadLaw(Section& model, Fem* fem) {
  fem->is_law_default = !model.Has("law");
  if (fem->is_law_default) {
    fem->law = DefaultLaw(fem->time);
    return;
  }
  fem->law = model.OneOf<Fem::Law>("law", {{"corotational", Fem::Law::kCorotational},
                                           {"linear", Fem::Law::kLinear},
                                           {"neo-hookean", Fem::Law::kNeoHookean},
                                           {"ogden", Fem::Law::kOgden}});
  if (fem->law == Fem::Law::kOgden) fem->terms = ReadTerms(model);
}

void ReadFem(Section& model, Fem* fem) {
  ReadElement(model, fem);
  ReadMotion(model, fem);
  ReadLaw(model, fem);
  fem->residual = model.Number("residual");
  fem->gravity_O = model.Vector3("gravity");
}

bool IsFem(const ModelKind& kind) {
  return kind.name == "fem";
}

void ReadContact(Section& model, const ModelKind& kind, ModelOptions* options) {
  using Law = Section::Choice<ContactLaw>;
  constexpr std::array kLaws{Law{"bonded", ContactLaw::kBonded},
                             Law{"frictionless", ContactLaw::kFrictionless},
                             Law{"friction", ContactLaw::kFriction}};
  const bool follows = FollowsTools(*options);
  const std::size_t count = follows ? 3 : kind.accepts_frictionless && !IsFem(kind) ? 2 : 1;
  const char* note = follows || kind.name == "auto" ? ""
                     : IsFem(kind)                  ? ": `fem` needs tet4, statics and another law"
                                                    : " with this kind";
  options->contact = model.OneOfTable<ContactLaw>("contact", std::span(kLaws).first(count), note);
  if (options->contact == ContactLaw::kFriction) {
    options->friction = model.Number("friction");
  } else if (model.Has("friction")) {
    model.Refuse("friction", follows ? "nothing without `contact: friction`"
                                     : "nothing here: use fem with element: tet4, time: static");
  }
}

std::string ReadKind(Section& model) {
  using ModelName = Section::Choice<std::string_view>;
  std::array<ModelName, kModelKinds.size() + 1> kinds{ModelName{"auto", "auto"}};
  for (std::size_t i = 0; i < kModelKinds.size(); ++i) {
    kinds[i + 1] = {kModelKinds[i].name, kModelKinds[i].name};
  }
  return std::string(model.OneOfTable<std::string_view>("kind", kinds));
}

// Returns the options of the kind; for `auto`, which may become any kind, most of them.
ModelKind OptionsOf(std::string_view name) {
  if (const ModelKind* kind = FindModelKind(name)) return *kind;
  return {.name = "auto",
          .linearity = Linearity::kByLaw,
          .has_tets = true,
          .iterates = true,
          .accepts_frictionless = true,
          .takes_tension = true,
          .is_plane = true};
}

// Returns whether a query may end before Newton's method has converged.
bool TakesSteps(const FemOptions& fem) {
  return fem.element == FemOptions::Element::kTet4 && fem.law != FemOptions::Law::kOgden &&
         fem.time == FemOptions::Time::kStatic;
}

}  // namespace

ModelOptions ReadModel(Section& scene, const SceneContext& context) {
  Section model = scene.Open("model", "a map of kind, elements, plane, contact, ...");
  ModelOptions options;
  options.kind = ReadKind(model);
  const ModelKind kind = OptionsOf(options.kind);
  const bool is_auto = options.kind == "auto";
  const bool is_membrane = kind.object == ObjectClass::kMembrane;
  if (is_auto || kind.object == ObjectClass::kOutline) ReadPlanar(model, kind, &options);
  if (kind.iterates) {
    ReadFem(model, &options.fem);
  } else if (kind.has_tets) {
    ReadElement(model, &options.fem);
  }
  if (kind.takes_relaxation) options.fem.step = model.Number("step");
  if (kind.takes_tension) {
    options.prestress = model.Number("prestress");
  } else if (is_membrane && model.Has("prestress")) {
    model.Refuse("prestress", "nothing with this kind: use plate-large for tension at rest");
  }
  if (!is_membrane) ReadContact(model, kind, &options);
  if (kind.iterates && TakesSteps(options.fem)) {
    options.deadline = model.Number("deadline");
  } else if (model.Has("deadline")) {
    model.Refuse("deadline",
                 "nothing here: use fem with element: tet4, time: static, any law but ogden");
  }
  if (kind.has_cache) {
    const std::string folder = model.Text("cache", "a folder", std::string());
    if (!folder.empty()) options.cache = context.folder / folder;
  }
  options.tolerance = model.Number("tolerance");
  options.rate = model.Number("rate");
  // Plates have ranges of their own, in thicknesses.
  if (!is_membrane) options.range = model.Number("range");
  Section puncture = model.Open("puncture");
  const bool has_from = puncture.Has("from");
  if (has_from) options.puncture_from = puncture.Number("from");
  if (puncture.Has("depth") || !has_from) {
    options.puncture_depth = puncture.Number("depth");
  }
  return options;
}

}  // namespace palpate
