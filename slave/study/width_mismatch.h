// Effective width of a tool on a mesh.
#pragma once

#include "slave/mechanics/object_mesh.h"
#include "slave/scene/scene.h"
#include "slave/study/press_spec.h"

namespace palpate::study {

// Returns whether its nodes are in the middles of edges, too.
bool HasMidnodes(const ModelOptions& model);

// Returns whether the model uses the tool's exact width on any mesh: plates.
bool TakesWidthAsItIs(const ObjectMesh& mesh);

// Relative error of a rigid tool's width on this mesh at `press`: a discrete contact consists of
// whole elements, triangles or nodes (for fem tet10 also mid-edge nodes). 0 if the model has no
// such error. NaN: no contact is possible there.
double WidthMismatch(const ObjectMesh& mesh, const ModelOptions& model, const Press& press,
                     double width);

}  // namespace palpate::study
