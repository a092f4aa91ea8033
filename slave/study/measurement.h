// One candidate, tried: how it answers the question and what that costs.
#pragma once

#include <functional>
#include <memory>

#include "shared/text/progress.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/study/candidate.h"
#include "slave/study/press_spec.h"
#include "slave/study/study_row.h"

namespace palpate::study {

// Where models and time come from; tests bring their own.
struct ModelFactory {
  std::function<std::unique_ptr<DeformationModel>(const Scene&, const ObjectMesh&, Progress*)> make;
  std::function<double()> now;  // [s], from any zero
};
ModelFactory RealWorkshop();

// Never throws: what goes wrong stands in the row; a precompute that `progress` stopped is skipped.
// `timing_s`: how long updates are repeated for the median, at least five and at most a thousand of
// them.
StudyRow Measure(const Candidate& candidate, const PressSpec& question,
                 const ModelFactory& workshop, Progress* progress, double timing_s = 0.15);

// The row of a candidate that did not run.
StudyRow Skipped(const Candidate& candidate, std::string reason);

}  // namespace palpate::study
