// The models a study tries on a scene: every applicable one, at several resolutions and residuals.
#pragma once

#include <string>
#include <vector>

#include "slave/mechanics/object_mesh.h"
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

// Whether nodes or elements are fixed by number, which depends on the division.
bool HoldsByNumber(const Scene& scene);

// Whether its nodes are in the middles of edges, too.
bool HasMidnodes(const ModelOptions& model);

// Whether the model takes the tool's width as it is, whatever its mesh: plates and shells.
bool TakesWidthAsItIs(const ObjectMesh& mesh, const ModelOptions& model);

// Relative error of a rigid tool's width on this mesh at `press`: a discrete contact consists of
// whole elements, triangles or nodes (for fem tet10 also those in the middle of edges). 0 if the
// model has none. NaN: no contact is possible there.
double WidthMismatch(const ObjectMesh& mesh, const ModelOptions& model, const Press& press,
                     double width);

}  // namespace palpate::study
