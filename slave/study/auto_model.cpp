#include "slave/study/auto_model.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "shared/text/text.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/factory/tool_domain.h"
#include "slave/mechanics/factory/tool_press.h"
#include "slave/scene/model_kinds.h"
#include "slave/study/mesh_division.h"
#include "slave/study/reachable_places.h"

namespace palpate::study {
namespace {

// Returns why the scene cannot run with this row's model, independent of error and rate; empty: it
// can.
std::string Unfit(const Scene& scene, const StudyRow& row) {
  const ModelKind* kind = FindModelKind(row.kind);
  if (kind == nullptr || kind->object != ObjectClass::kVolume) return {};
  const FemOptions& fem = scene.model.fem;
  if (row.model.refinements > 0 && HoldsByNumber(scene))
    return "the numbers of the fixed nodes change";
  if (!kind->iterates && fem.time == FemOptions::Time::kDynamic) return "is not dynamic";
  if (!kind->iterates && !fem.gravity_O.isZero(0)) return "has no gravity";
  if (scene.model.contact == ContactLaw::kFrictionless &&
      !(kind->iterates ? FollowsTools(row.model) : kind->accepts_frictionless)) {
    return "its contacts are bonded";
  }
  return {};
}

std::string WhyNot(const StudyRow& row, const StudyRow& chosen, const StudyResult& study) {
  if (row.outcome == Outcome::kSkipped) return "not tried: " + row.reason;
  if (row.outcome == Outcome::kFailed) return "no solution: " + row.reason;
  if (!std::isfinite(row.error.value)) return "its error is unknown";
  if (row.beyond > chosen.beyond) {
    return Formatted("beyond its range at %zu of %zu contacts", row.beyond, row.answers.size()) +
           (row.reason.empty() ? "" : ": " + row.reason);
  }
  if (!row.meets_tolerance) {
    const bool may = OnTolerance(row.error.value, row.bound, study.tolerance) == Promise::kMayMiss;
    return Formatted("%s the tolerance of %.3g %%", may ? "may miss" : "misses",
                     100 * study.tolerance);
  }
  if (!row.meets_rate) return Formatted("misses the rate of %.3g Hz", study.rate);
  return "meets both, and costs more";
}

RejectedModel Rejected(const StudyRow& row, std::string why) {
  return {row.name(), std::move(why), row.error.value, row.update_p99_s, row.precompute_s};
}

// Sorts the rows: the Pareto front first, then those with an answer, then the others.
void Sort(std::vector<StudyRow>* rows) {
  std::ranges::stable_sort(*rows, {}, [](const StudyRow& row) {
    return std::pair(!row.on_front, row.outcome != Outcome::kAnswered);
  });
}

Scene WithModel(const Scene& scene, const StudyRow& row) {
  Scene decided = scene;
  decided.model = row.model;
  decided.model.fem.time = scene.model.fem.time;
  decided.model.fem.gravity_O = scene.model.fem.gravity_O;
  if (auto* box = std::get_if<BoxGeometry>(&decided.object.geometry)) box->cells = row.cells;
  return decided;
}

// Returns the rows that fit the scene; the others are added to `rejected`.
std::vector<StudyRow> FitRows(const Scene& scene, std::vector<StudyRow> rows,
                              std::vector<RejectedModel>* rejected) {
  std::erase_if(rows, [&](const StudyRow& row) {
    std::string why = Unfit(scene, row);
    if (why.empty()) return false;
    rejected->push_back(Rejected(row, std::move(why)));
    return true;
  });
  return rows;
}

// Returns whether a volume's reference at several places takes some seconds, not minutes; boxes are
// always graded quickly.
bool IsQuicklyGraded(const Scene& scene) {
  constexpr std::size_t kQuickTets = 3'000;
  if (HoldsByNumber(scene)) return false;
  if (std::holds_alternative<BoxGeometry>(scene.object.geometry)) return true;
  const ObjectMesh mesh = MeshObject(scene, std::nullopt);
  const auto* solid = std::get_if<SolidMesh>(&mesh);
  return solid != nullptr && solid->tets.size() <= kQuickTets;
}

// Moves the contacts to few radii, because the solid for camera measurements takes a second for
// each radius.
void KeepToFewRadii(const Geometry& geometry, std::vector<Eigen::Vector3d>* places) {
  const auto* membrane = std::get_if<MembraneGeometry>(&geometry);
  if (membrane == nullptr) return;
  constexpr double kRaster = 2.0 / 13;  // distance between radii, relative to the membrane's radius
  const double raster = kRaster * membrane->radius;
  for (Eigen::Vector3d& p_O : *places) {
    const double radius = p_O.norm();
    if (radius > 0) p_O *= raster * std::round(radius / raster) / radius;
  }
}

}  // namespace

bool CanStudy(const Scene& scene) {
  return IsHeld(scene.object) &&
         !std::holds_alternative<ImageContourGeometry>(scene.object.geometry) &&
         !std::holds_alternative<DomeGeometry>(scene.object.geometry);
}

ModelDecision StatedOf(const StudyRow& row) {
  return {.meets = row.meets_tolerance && row.meets_rate && row.beyond == 0,
          .error = row.error.value,
          .bound = row.bound,
          .update = row.update_p99_s};
}

std::optional<Scene> DecidedBy(StudyResult study, const Scene& scene) {
  std::vector<RejectedModel> unfit;
  study.rows = FitRows(scene, std::move(study.rows), &unfit);
  MarkFront(&study.rows);
  const std::string reason = "auto: " + Recommend(study.tolerance, study.rate, &study.rows);
  Sort(&study.rows);
  const auto chosen = std::ranges::find_if(study.rows, &StudyRow::recommended);
  if (chosen == study.rows.end()) return std::nullopt;
  ModelDecision decision = StatedOf(*chosen);
  decision.reason = reason;
  if (study.question.presses.size() < kMany && scene.study_contacts.empty()) {
    decision.reason += "; evaluated where the tool would first touch the object, unknown elsewhere";
  }
  for (const StudyRow& row : study.rows) {
    if (!row.recommended) decision.rejected.push_back(Rejected(row, WhyNot(row, *chosen, study)));
  }
  decision.rejected.insert(decision.rejected.end(), unfit.begin(), unfit.end());
  Scene decided = WithModel(scene, *chosen);
  decided.model.decision = std::move(decision);
  return decided;
}

std::vector<Eigen::Vector3d> PlacesToDecide(const Scene& scene) {
  // At least 29 are needed for a 95 % bound of the 90th percentile (BeyondBound).
  constexpr int kOnOutline = 128, kMinOnSurface = 29;
  const bool has_own = !scene.study_contacts.empty() || !scene.tool;
  if (has_own) return {};
  const auto is_slow = [&] { return IsTouchedRound(scene) || !IsQuicklyGraded(scene); };
  if (IsVolume(scene.object.geometry) && is_slow()) return {};
  const Geometry& geometry = scene.object.geometry;
  const int count = IsPlanar(geometry) ? kOnOutline : kMinOnSurface;
  auto places = ReachablePlaces(scene, scene.tool->width, SpreadShares(count));
  if (HasStereoOrDepth(scene.sense)) KeepToFewRadii(geometry, &places);
  return places;
}

StudySettings QuickSettings(const Scene& scene, double budget_s) {
  StudySettings settings;
  settings.places = PlacesToDecide(scene);
  // Volumes take longer at many positions than planar objects.
  const bool at_many = IsVolume(scene.object.geometry) && settings.places.size() >= kMany;
  settings.budget_s = budget_s * (at_many ? 2 : 1);
  settings.counted = true;
  settings.timing_s = 0.01 * budget_s;
  settings.limits = {.dof = 40'000, .dense_dof = 1200, .residuals = false, .linear_fem = false};
  return settings;
}

std::optional<Scene> DecideQuickly(const Scene& scene, const ModelFactory& factory, double budget_s,
                                   const std::stop_token& stop, Progress* progress) {
  Scene weightless = scene;  // the force of a press does not depend on the weight
  weightless.model.fem.gravity_O.setZero();
  const StudySettings settings = QuickSettings(scene, budget_s);
  return DecidedBy(RunStudy(weightless, settings, factory, stop, {{}, progress}), scene);
}

std::optional<Scene> DecideOnThickness(const Scene& scene) {
  const bool is_possible = IsPlanar(scene.object.geometry) && scene.tool && scene.tool->depth &&
                           scene.tool->shape == Tool::Shape::kFlat &&
                           scene.model.contact == ContactLaw::kBonded &&
                           scene.object.material.poisson_ratio <= kMaxExtrudedNu;
  if (!is_possible) return std::nullopt;
  Scene plane = scene, solid = scene;
  plane.model.kind = "bem2d";
  solid.model.kind = "extruded";
  const BoundaryMesh mesh = MeshOutline(scene, std::nullopt);
  if (PlaneError(plane, *scene.tool, mesh) <= scene.model.tolerance) return std::nullopt;
  const PressSpec question = AskedOf(plane, {});
  const Press& press = question.presses.front();
  const auto force = [&](const Scene& at) {
    const Contact contact{Contact::Kind::kDisplacement, press.p_O, -1, question.width,
                          question.small_depth * press.inward_O};
    ContactResponse response;
    MakeModel(at, mesh)->Respond({&contact, 1}, {&response, 1});
    return response.validity == Validity::kFailed ? kUnknown : response.force_O.norm();
  };
  const double by_plane = force(plane), by_solid = force(solid);
  if (!(by_plane > 0 && by_solid > 0)) return std::nullopt;
  solid.model.decision.reason =
      "auto: extruded: under this tool " +
      std::string(scene.model.plane == Plane::kStress ? "plane stress" : "plane strain") +
      Formatted(" has %.2f times the force of the body with its thickness", by_plane / by_solid);
  solid.model.decision.error = solid.model.decision.bound = PlaneError(solid, *scene.tool, mesh);
  solid.model.decision.meets = solid.model.decision.error <= scene.model.tolerance;
  return solid;
}

OwnModel StudyOwn(Scene scene, const ModelFactory& factory, Progress* progress) {
  if (!CanStudy(scene)) {
    throw std::invalid_argument(
        "the object has no fixed boundary, so only balanced loads are accepted");
  }
  const bool is_decided = !scene.model.decision.reason.empty();
  scene.model.kind = ChooseModel(scene).kind;
  scene.model.fem.gravity_O.setZero();
  StudySettings settings;
  settings.timing_s = 0.01;
  settings.limits = {.residuals = false, .own = true, .large = !is_decided};
  // The decision states the error already; references of outlines are plane.
  const bool is_solid_outline = IsPlanar(scene.object.geometry) && !KindOf(scene).is_plane;
  settings.compares = !is_decided && !is_solid_outline;
  StudyResult study = RunStudy(scene, settings, factory, StopOf(progress), {{}, progress});
  const auto own = std::ranges::find_if(study.rows, [&](const StudyRow& row) {
    return row.own && IsSameModel(row.model, scene.model);
  });
  if (own == study.rows.end()) throw std::invalid_argument("no study knows this model");
  if (is_solid_outline) {
    own->error.value = own->bound =
        PlaneError(scene, scene.tool.value(), MeshOutline(scene, std::nullopt));
  }
  return {std::move(study.question), std::move(*own)};
}

}  // namespace palpate::study
