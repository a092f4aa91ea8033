// Creates the model of a scene.
#pragma once

#include <memory>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/program/progress.h"
#include "slave/scene/model_kinds.h"
#include "slave/scene/scene.h"

namespace palpate {

class Bem2dModel;
class ExtrudedModel;
class PlateSurface;

// The kind of the scene's model; of `auto` the one that ChooseModel takes. Throws
// std::invalid_argument: no such kind.
const ModelKind& KindOf(const Scene& scene);
// Returns whether that model computes the contact region of the scene's tool itself, see ShapesTool
// (model_kinds.h).
bool ShapesTool(const Scene& scene);
// Returns whether each Respond of the scene's model is a time step.
bool MovesInTime(const Scene& scene);
bool IsLinear(const Scene& scene);
// Precomputes the model; reports expected cost and progress to `progress`, if there is one. Throws
// std::invalid_argument: no fixed part, impossible combination (with the reason); Interrupted.
std::unique_ptr<DeformationModel> MakeModel(const Scene& scene, const ObjectMesh& mesh,
                                            Progress* progress = nullptr);
// Creates the model of a known family of kinds: bem2d; plate or plate-large.
std::unique_ptr<Bem2dModel> MakePlanarModel(const Scene& scene, const BoundaryMesh& mesh,
                                            Progress* progress = nullptr);
// Whether `extruded` computes such an outline under such a tool.
bool AcceptsExtruded(const Scene& scene);
// Makes `extruded`, which prepares each place of the tool at its first contact.
std::unique_ptr<ExtrudedModel> MakeExtrudedModel(const Scene& scene, const BoundaryMesh& mesh);
std::unique_ptr<PlateSurface> MakePlateModel(const Scene& scene, const MembraneDisc& disc,
                                             Progress* progress = nullptr);

// Nodes that the models of volumes fix: those of the scene's supports, and those without a
// tetrahedron, which have no stiffness.
HeldNodes HeldTetNodes(const Scene& scene, const SolidMesh& mesh);
// Returns the width of the contacts of a scene [m]: that of its fingertips, else of its tool; 0:
// points.
double ContactWidth(const Scene& scene);

}  // namespace palpate
