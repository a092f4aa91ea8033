// Reference forces of presses on a scene's object. They come from a formulation that the tested
// models do not share, or from a much finer mesh.
#pragma once

#include <vector>

#include "slave/scene/scene.h"
#include "slave/study/press_spec.h"

namespace palpate::model_selection {

// Returns the force along the tool's path at the press depth for each press by a rigid tool [N];
// NaN: not found.
//
// planar: quadratic finite elements graded towards the tool's ends (PlanarStiffness);
// membrane: a neo-Hookean solid of cubic hexahedra (PressedMembrane);
// volume: quadratic tetrahedra, w / 5 and shorter under the tool of width w, times how much
// stiffer neo-Hookean ones of w / 2 are at the depth than at a small one.
std::vector<double> TrueForces(const Scene& scene, const study::PressSpec& question);

}  // namespace palpate::model_selection
