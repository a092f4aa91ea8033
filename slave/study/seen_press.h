// SeePresses computes the presses of a study as the cameras in front of a membrane measure them.
#pragma once

#include <vector>

#include "slave/scene/scene.h"
#include "slave/study/press_spec.h"

namespace palpate::study {

// Relative error of the computed forces against the limit of a refined solid [-]. [derived: 0.2 %
// of the mesh, and 0.3 % of the difference from another program's solid, see pressed_membrane_test]
inline constexpr double kSeenForce = 0.006;

// Returns one SeenPress per press at the question's depth, computed by a neo-Hookean solid
// (PressedMembrane); about a second for each radius. Empty: no membrane before a stereo pair or
// depth camera, or the solid has no equilibrium at this depth.
std::vector<SeenPress> SeePresses(const Scene& scene, const PressSpec& question);

}  // namespace palpate::study
