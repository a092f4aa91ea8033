// Measures one candidate: its results for the study's contacts, and their cost.
#pragma once

#include <functional>
#include <memory>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/program/progress.h"
#include "slave/study/candidate.h"
#include "slave/study/press_spec.h"
#include "slave/study/study_row.h"

namespace palpate::study {

// Creates models and provides the time; tests use their own.
struct ModelFactory {
  std::function<std::unique_ptr<DeformationModel>(const Scene&, const ObjectMesh&, Progress*)> make;
  std::function<double()> now;  // [s], from any zero
  // Processor time of the calling thread [s]; empty: `now` is used.
  std::function<double()> work{};
};
ModelFactory DefaultModelFactory();

// Never throws: errors are stored in the row; a precompute that `progress` stopped is skipped.
// `timing_s`: time for repeated updates, at least five and at most a thousand, of which the median
// is used.
StudyRow Measure(const Candidate& candidate, const PressSpec& question, const ModelFactory& factory,
                 Progress* progress, double timing_s = 0.15);

// The row of a candidate that did not run.
StudyRow Skipped(const Candidate& candidate, std::string reason);

}  // namespace palpate::study
