// The error and the time of a scene's own model, which `check` prints.
#pragma once

#include "slave/scene/scene.h"
#include "slave/study/study.h"

namespace palpate::study {

// Whether a study is possible: the object has a fixed part, and its outline is known without an
// image.
bool CanStudy(const Scene& scene);

// The study's result for the scene's own model, at the study's default contacts.
struct OwnModel {
  PressSpec question;
  StudyRow row;
};
// Seconds. Throws std::invalid_argument: see AskedOf; nothing is fixed. A stop of `progress` ends
// it: Interrupted, or a row without answer.
OwnModel StudyOwn(Scene scene, const ModelFactory& factory, Progress* progress = nullptr);

}  // namespace palpate::study
