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

// Cheapest first. `scene.model.kind` is not looked at, its other options are kept; the scene's own
// resolution is always among them.
std::vector<Candidate> CandidatesFor(const Scene& scene, const PressSpec& question,
                                     const CandidateLimits& limits = {});

// Whether nodes or elements are held by number, which another division gives to others.
bool HoldsByNumber(const Scene& scene);

// Whether its nodes are in the middles of edges, too.
bool HasMidnodes(const ModelOptions& model);

// Whether the model takes the tool's width as it is, whatever its mesh: plates and shells.
bool TakesWidthAsItIs(const ObjectMesh& mesh, const ModelOptions& model);

// How wide a rigid tool a model on this mesh sees at `press`, relative to the real one, minus 1: a
// discrete patch is made of whole elements, triangles or nodes (of fem tet10, those amid edges
// too). 0 where the model has none. NaN: nothing can be touched there.
double WidthMismatch(const ObjectMesh& mesh, const ModelOptions& model, const Press& press,
                     double width);

}  // namespace palpate::study
