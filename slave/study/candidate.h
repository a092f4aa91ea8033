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
  bool residuals = true;                   // iterative solvers at several residuals
  std::vector<std::string> families = {};  // only these; empty: all
  bool own = false;                        // only the scene's own model
  bool large = true;  // includes models of large deformation at that resolution
};

// Returns whether both are one model, but for its resolution.
bool IsSameModel(const ModelOptions& a, const ModelOptions& b);

// Returns the candidates, the cheapest first, numbered in this order. The scene's own model (none
// of the kind `auto`) and its resolution are always included; its other options are kept.
std::vector<Candidate> CandidatesFor(const Scene& scene, const PressSpec& question,
                                     const CandidateLimits& limits = {});

}  // namespace palpate::study
