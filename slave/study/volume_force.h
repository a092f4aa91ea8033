// Volumes under a rigid tool, solved on a mesh made for the press.
#pragma once

#include <optional>

#include "slave/scene/scene.h"
#include "slave/study/press_spec.h"
#include "slave/study/study_row.h"

namespace palpate::study {

// Longest edges under a tool and at its rim, relative to the width that it touches [-], and their
// growth with the distance from there. Against pressed_box.py and pressed_profile.py of the
// campaigns, the force of flat tools on a box was within 0.3 % with {0.25, 0.25, 1.5} [measured: nu
// 0.3 and 0.45, sliding and bonded].
struct Grading {
  double under = 0, rim = 0, growth = 0;
};
inline constexpr Grading kFineGrading{0.25, 0.25, 1.5};

// Returns whether VolumeForce applies: the mesh has tetrahedra, and its supports are not node
// numbers.
bool HasVolumeForce(const Scene& scene);

// Returns the force of the scene's tool along its direction at `depth` [N], small strain: fem-green
// with ten-node tetrahedra, whose stated error is the bar. Where the tool touches is part of the
// solution (ToolPress). The shape of the object is that of its mesh. nullopt: not applicable, no
// surface at the position, object not fixed, or more than 50,000 tetrahedra. Some seconds.
std::optional<Estimate> VolumeForce(const Scene& scene, const Press& press, double width,
                                    double depth, const Grading& grading);

}  // namespace palpate::study
