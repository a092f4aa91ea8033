#include "slave/study/own_model.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "slave/mechanics/factory/choose_model.h"
#include "slave/scene/model_kinds.h"

namespace palpate::study {

bool CanStudy(const Scene& scene) {
  return IsHeld(scene.object) &&
         !std::holds_alternative<ImageContourGeometry>(scene.object.geometry) &&
         !std::holds_alternative<DomeGeometry>(scene.object.geometry);
}

OwnModel StudyOwn(Scene scene, const ModelFactory& factory, Progress* progress) {
  if (!CanStudy(scene)) {
    throw std::invalid_argument(
        "the object has no fixed boundary, so only balanced loads are accepted");
  }
  scene = WithChosenModel(std::move(scene));
  scene.model.fem.gravity_O.setZero();  // the force of a press does not depend on the weight
  StudySettings settings;
  settings.timing_s = 0.01;
  settings.limits = {.residuals = false, .own = true};
  // References of outlines are plane.
  settings.compares = !IsSolidOutline(scene.model.kind);
  StudyResult study = RunStudy(scene, settings, factory, StopOf(progress), {{}, progress});
  const auto own = std::ranges::find_if(study.rows, &StudyRow::own_model);
  if (own == study.rows.end()) throw std::invalid_argument("no study knows this model");
  return {std::move(study.question), std::move(*own)};
}

}  // namespace palpate::study
