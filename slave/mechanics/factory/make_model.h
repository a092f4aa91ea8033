// From a scene to the model that runs.
#pragma once

#include <memory>
#include <string>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/program/progress.h"
#include "slave/scene/model_kinds.h"
#include "slave/scene/scene.h"

namespace palpate {

class Bem2dModel;
class PlateSurface;

struct ModelChoice {
  std::string kind;    // never `auto`
  std::string reason;  // one sentence
};

// The decision of `kind: auto`, and its reason.
ModelChoice ChooseModel(const Scene& scene);
// That kind. Throws std::invalid_argument: no kind of model.
const ModelKind& KindOf(const Scene& scene);
// Whether that model finds itself where the scene's tool touches, see ShapesTool (model_kinds.h).
bool ShapesTool(const Scene& scene);
// Whether a Respond of the scene's model is a step of time.
bool MovesInTime(const Scene& scene);
bool IsLinear(const Scene& scene);
// Precomputes the model; reports expected cost and progress to `progress`, if there is one. Throws
// std::invalid_argument: no fixed part, impossible combination (with the reason); Interrupted.
std::unique_ptr<DeformationModel> MakeModel(const Scene& scene, const ObjectMesh& mesh,
                                            Progress* progress = nullptr);
// The same where the kind's family is known: bem2d; plate or plate-large.
std::unique_ptr<Bem2dModel> MakePlanarModel(const Scene& scene, const BoundaryMesh& mesh,
                                            Progress* progress = nullptr);
std::unique_ptr<PlateSurface> MakePlateModel(const Scene& scene, const MembraneDisc& disc,
                                             Progress* progress = nullptr);

// What the models of volumes hold of a scene: also nodes that belong to no tetrahedron, which have
// no stiffness of their own.
HeldNodes HeldTetNodes(const Scene& scene, const SolidMesh& mesh);
// The width of the contacts of a scene [m]: that of its fingertips, else of its tool; 0: points.
double ContactWidth(const Scene& scene);

}  // namespace palpate
