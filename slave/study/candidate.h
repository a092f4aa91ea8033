// The models a study tries on a scene: every applicable one, at several resolutions and residuals.
#pragma once

#include <string>
#include <vector>

#include "slave/scene/scene.h"
#include "slave/study/press_spec.h"
#include "slave/study/study_row.h"

namespace palpate::study {

struct Candidate : Trait {  // `dof` is expected, `expected_s` a rough prior
  Scene scene;              // with the model options of this candidate
};

struct CandidateLimits {
  std::size_t dof = 200'000;               // of sparse models
  std::size_t dense_dof = 4000;            // of models with a dense inverse
  bool residuals = true;                   // iterative solvers at several residuals, not one only
  std::vector<std::string> families = {};  // these only; empty: all
};

// Cheapest first. `scene.model.kind` is ignored, its other options are kept; the scene's own
// resolution is always included.
std::vector<Candidate> CandidatesFor(const Scene& scene, const PressSpec& question,
                                     const CandidateLimits& limits = {});

}  // namespace palpate::study
