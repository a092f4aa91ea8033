// From a scene to the model that runs.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "shared/mesh/outline.h"
#include "shared/scene/scene.h"
#include "slave/mechanics/deformation_model.h"

namespace palpate {

struct ModelChoice {
  std::string kind;    // never `auto`
  std::string reason;  // one sentence
};

// What `kind: auto` comes to, and why.
ModelChoice ChooseModel(const Scene& scene);
// Divides the scene's outline into model.elements elements, frame O. `seen`: the outline found by
// the eyes, used for `contour: from-image`. Throws std::invalid_argument: nothing seen where it is
// needed, fewer than three elements.
BoundaryMesh MeshObject(const Scene& scene, const std::optional<Outline>& seen);
// Precomputes the model. Throws std::invalid_argument: fixed nothing, impossible combination (says
// why).
std::unique_ptr<DeformationModel> MakeModel(const Scene& scene, const BoundaryMesh& mesh);

}  // namespace palpate
