// The kinds of deformation models, with their properties and options. One row per kind, used by all
// code that reads, checks, replaces, studies or queries a model.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "slave/scene/scene.h"

namespace palpate {

enum class ObjectClass : std::uint8_t { kOutline, kMembrane, kVolume, kDome };

// Whether displacements are proportional to the load.
enum class Linearity : std::uint8_t {
  kAlways,
  kByLaw,  // only if model.law is linear
  kNever,  // its formulation includes large deflections or strains
};

struct ModelKind {
  std::string_view name;  // as in model.kind
  ObjectClass object = ObjectClass::kVolume;
  Linearity linearity = Linearity::kAlways;
  bool has_tets = false;              // accepts element
  bool iterates = false;              // accepts law, residual, gravity, time
  bool accepts_frictionless = false;  // accepts contact: bonded or frictionless; false: bonded only
  bool has_cache = false;             // stores its Green's functions in a folder
  bool takes_tension = false;         // of a membrane at rest
  bool takes_regions = false;         // whether parts of the object may have other moduli
  bool takes_relaxation = false;      // moduli that fade in time; accepts step
  bool is_plane = false;              // a plane model; accepts the keys plane and order
};

// Largest Poisson's ratio of `extruded`, whose quadratic triangles lock beyond it [-]. [measured: a
// cube becomes 4 % stiffer from 0.49 to here]
inline constexpr double kMaxExtrudedNu = 0.499;

// `auto` is no kind: ChooseModel (mechanics/factory/choose_model.h) names one.
inline constexpr std::array kModelKinds{
    ModelKind{.name = "bem2d",
              .object = ObjectClass::kOutline,
              .accepts_frictionless = true,
              .is_plane = true},
    ModelKind{.name = "extruded", .object = ObjectClass::kOutline},
    ModelKind{.name = "plate", .object = ObjectClass::kMembrane},
    ModelKind{.name = "plate-large",
              .object = ObjectClass::kMembrane,
              .linearity = Linearity::kNever,
              .takes_tension = true},
    ModelKind{.name = "membrane", .object = ObjectClass::kDome, .takes_tension = true},
    ModelKind{.name = "fem",
              .linearity = Linearity::kByLaw,
              .has_tets = true,
              .iterates = true,
              .accepts_frictionless = true,
              .takes_regions = true},
    ModelKind{.name = "fem-green",
              .has_tets = true,
              .accepts_frictionless = true,
              .has_cache = true,
              .takes_regions = true,
              .takes_relaxation = true},
};

// nullptr: `auto`, or no kind at all.
inline const ModelKind* FindModelKind(std::string_view name) {
  const auto* found = std::ranges::find(kModelKinds, name, &ModelKind::name);
  return found == kModelKinds.end() ? nullptr : found;
}
inline ObjectClass ClassOf(const Geometry& geometry) {
  if (IsVolume(geometry)) return ObjectClass::kVolume;
  if (std::holds_alternative<DomeGeometry>(geometry)) return ObjectClass::kDome;
  return IsPlanar(geometry) ? ObjectClass::kOutline : ObjectClass::kMembrane;
}
// Whether it is a model of an outline with its thickness.
inline bool IsSolidOutline(std::string_view name) {
  const ModelKind* kind = FindModelKind(name);
  return kind != nullptr && kind->object == ObjectClass::kOutline && !kind->is_plane;
}
// Whether large deflections or strains are part of the model's own formulation.
inline bool IsLargeDeformation(const ModelOptions& model) {
  const ModelKind* kind = FindModelKind(model.kind);
  if (kind == nullptr) return false;
  return kind->linearity == Linearity::kNever || (kind->iterates && IsHyperelastic(model.fem.law));
}
// Returns whether the model determines the contact region of rigid tools of every shape with
// Coulomb friction: static `fem` with four-node tetrahedra and any law except Ogden's.
inline bool FollowsTools(const ModelOptions& model) {
  const ModelKind* kind = FindModelKind(model.kind);
  return kind != nullptr && kind->iterates && model.fem.element == FemOptions::Element::kTet4 &&
         model.fem.law != FemOptions::Law::kOgden && model.fem.time == FemOptions::Time::kStatic;
}
// Returns whether the model determines the contact region and the friction of this tool. Other
// tools are bonded, and flat ones fix their nodes.
inline bool ShapesTool(const ModelOptions& model, const Tool& tool) {
  const bool is_usual = tool.shape == Tool::Shape::kFlat || tool.shape == Tool::Shape::kRound;
  return FollowsTools(model) && (model.contact != ContactLaw::kBonded || !is_usual);
}
// Whether model.kind may be `kind` for such an object: one of its kinds, or `auto`.
inline bool IsKindFor(ObjectClass object, std::string_view kind) {
  const ModelKind* found = FindModelKind(kind);
  return kind == "auto" || (found != nullptr && found->object == object);
}
// The kinds as text: "auto, plate or plate-large".
inline std::string KindsFor(ObjectClass object) {
  std::string words = "auto";
  std::string_view last;
  for (const ModelKind& kind : kModelKinds) {
    if (kind.object != object) continue;
    if (!last.empty()) words.append(", ").append(last);
    last = kind.name;
  }
  return words.append(" or ").append(last);
}

// The kinds with an ability as text: "fem or fem-green".
inline std::string KindsWith(bool ModelKind::*ability) {
  std::string words;
  std::string_view last;
  for (const ModelKind& kind : kModelKinds) {
    if (!(kind.*ability)) continue;
    if (!last.empty()) words.append(words.empty() ? "" : ", ").append(last);
    last = kind.name;
  }
  return words.append(words.empty() ? "" : " or ").append(last);
}

}  // namespace palpate
