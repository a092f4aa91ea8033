// The models of volumes, from a scene.
#pragma once

#include <memory>

#include "shared/text/progress.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/scene/scene.h"

namespace palpate {

// `fem` and `fem-hyperelastic`: four-node tetrahedra, linear or co-rotational, by their own fast
// model; ten nodes, hyperelasticity and an own pressure by the general one.
std::unique_ptr<DeformationModel> MakeFem(const Scene& scene, const SolidMesh& mesh,
                                          Progress* progress);
std::unique_ptr<DeformationModel> MakeFemGreen(const Scene& scene, const SolidMesh& mesh,
                                               Progress* progress);
// A triangle is held where its three nodes are.
std::unique_ptr<DeformationModel> MakeBem3d(const Scene& scene, const SurfaceMesh& mesh,
                                            Progress* progress);

}  // namespace palpate
