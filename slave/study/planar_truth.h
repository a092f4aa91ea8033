// A planar object pressed by a bonded tool, solved by a formulation that no model shares: quadratic
// finite elements on a mesh graded towards the ends of the tool, where the stress is singular.
#pragma once

#include <optional>

#include "slave/scene/scene.h"
#include "slave/study/press_spec.h"
#include "slave/study/study_row.h"

namespace palpate::study {

// Force of the tool along its way per displacement [N/m]; the bar is the change from a coarser
// mesh. nullopt where the formulation does not apply: frictionless contact, supports named by
// element, not planar, no mesh. About half a second.
std::optional<Estimate> PlanarStiffness(const Scene& scene, const Press& press, double width);

}  // namespace palpate::study
