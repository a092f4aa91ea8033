// Volumes under a rigid tool, solved on a mesh made for the contact.
#pragma once

#include <optional>

#include "shared/mesh/solid_mesh.h"
#include "slave/scene/scene.h"
#include "slave/study/press_spec.h"

namespace palpate::study {

inline constexpr double kFineGrowth = 0.7;

// Refines the scene's tetrahedra until no edge under a tool of `width` [m] is longer than `finest`
// [m]; outside the limit grows by `growth` times the distance from the tool's rim. The shape of the
// object is unchanged.
SolidMesh GradedUnder(const Scene& scene, const Press& press, double width, double finest,
                      double growth = kFineGrowth);

// Returns whether VolumeStiffness applies: the mesh has tetrahedra, and its supports are not node
// numbers.
bool HasVolumeStiffness(const Scene& scene);

// Returns the force of a rigid tool, bonded or sliding as in the scene, along its direction per
// displacement [N/m], small strain: quadratic tetrahedra on that mesh, nodes under the tool move
// together, scaled to the tool's true width as a flat punch on a half-space, whose force is
// proportional to the width. With `finest` = width / 2, / 3, / 4 a block was 1.3, 0.4, 0.02 % below
// width / 6; a growth of 1.5 added up to 1 %, of 3 up to 2 %, and took a half and a quarter of the
// time. nullopt: not applicable, no surface at the position, object not fixed, or more than 50,000
// tetrahedra. A third of a second at width / 3, a tenth with a growth of 3 at width / 2.
std::optional<double> VolumeStiffness(const Scene& scene, const Press& press, double width,
                                      double finest, double growth = kFineGrowth);

// Force of the scene's round tool along its direction at `depth` [N], small strain: quadratic
// tetrahedra on a mesh with `across` edges across Hertz's contact, 2 sqrt(R depth), and the places
// that touch by RoundIndenter. nullopt: as above.
std::optional<double> VolumeRoundForce(const Scene& scene, const Press& press, double depth,
                                       int across, double growth = kFineGrowth);

}  // namespace palpate::study
