// `model.kind: auto`: the model that a study finds cheapest among those that meet the scene's
// tolerance and rate.
#pragma once

#include <optional>
#include <vector>

#include "slave/scene/scene.h"
#include "slave/study/study.h"

namespace palpate::study {

// Whether a study can tell: something holds the object, and its outline is known without an image.
bool CanStudy(const Scene& scene);

// `scene` with the model that its study recommends, at the resolution that was studied, and with
// what was decided. What the scene asks for besides (time, gravity, friction, tension) is kept, and
// no model is taken that cannot do it. nullopt: no such model answered with a known error.
std::optional<Scene> DecidedBy(StudyResult study, const Scene& scene);

inline constexpr double kQuickBudget = 3;  // [s]
// Of a study that decides for all of an object: where the scene names no places itself, it presses
// at several that go evenly over all ReachablePlaces. Empty: the study's own, as of volumes from a
// file of more than 3000 tetrahedra, which would take minutes, and of those held by number; then
// the decision says so.
std::vector<Eigen::Vector3d> PlacesToDecide(const Scene& scene);
// A quick study leaves out dear models, and repeating what is quick; volumes at many places have
// twice the time, shells three times.
StudySettings QuickSettings(const Scene& scene, double budget_s = kQuickBudget);
// The same after a quick study of about `budget_s` [s]. Throws std::invalid_argument: see AskedOf.
std::optional<Scene> DecideQuickly(const Scene& scene, const ModelFactory& workshop,
                                   double budget_s = kQuickBudget, const std::stop_token& stop = {},
                                   Progress* progress = nullptr);

}  // namespace palpate::study
