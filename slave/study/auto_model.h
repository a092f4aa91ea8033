// `model.kind: auto`: the model that a study finds cheapest among those that meet the scene's
// tolerance and rate.
#pragma once

#include <optional>
#include <vector>

#include "slave/scene/scene.h"
#include "slave/study/study.h"

namespace palpate::study {

// Returns whether a study is possible: the object has a fixed part, and its outline is known
// without an image.
bool CanStudy(const Scene& scene);

// Returns the data about a studied model that all commands report, without reason and rejected
// models.
ModelDecision StatedOf(const StudyRow& row);

// `scene` with the model that its study recommends, at the studied resolution, and with the
// decision. Further requirements of the scene (time, gravity, friction, tension) are kept, and
// models that do not meet them are rejected. nullopt: no such model has a known error.
std::optional<Scene> DecidedBy(StudyResult study, const Scene& scene);

inline constexpr double kQuickBudget = 3;  // [s]
// Returns the contacts of a study that decides for a whole object: if the scene names none, several
// that are spread evenly over all ReachablePlaces. Empty: the study's default. It is also empty for
// mesh files with more than 3000 tetrahedra or a round tool, which would take minutes, and for
// nodes that are fixed by number; the decision then states this.
std::vector<Eigen::Vector3d> PlacesToDecide(const Scene& scene);
// A quick study skips expensive models and repetitions; volumes with many contacts get twice the
// time.
StudySettings QuickSettings(const Scene& scene, double budget_s = kQuickBudget);
// Decides after a quick study of about `budget_s` [s]. Throws std::invalid_argument: see AskedOf.
std::optional<Scene> DecideQuickly(const Scene& scene, const ModelFactory& factory,
                                   double budget_s = kQuickBudget, const std::stop_token& stop = {},
                                   Progress* progress = nullptr);

// Decides for `extruded` if the scene is an outline under a flat tool, for which a plane model's
// error would exceed the tolerance. The reason states the force of the plane model divided by that
// of one extruded solution. nullopt: a plane model is sufficient, or the extruded one cannot be
// used. Takes about a second.
std::optional<Scene> DecideOnThickness(const Scene& scene);

// The study's result for the scene's own model, at the study's default contacts.
struct OwnModel {
  PressSpec question;
  StudyRow row;
};
// Seconds. Throws std::invalid_argument: see AskedOf; nothing is fixed. A stop of `progress` ends
// it: Interrupted, or a row without answer.
OwnModel StudyOwn(Scene scene, const ModelFactory& factory, Progress* progress = nullptr);

}  // namespace palpate::study
