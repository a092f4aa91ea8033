// Motion of the tool for runs without an operator: straight ahead from home into the body, a hold,
// and back.
#pragma once

#include "slave/scene/scene.h"
#include "slave/simulator/environment/press_motion.h"

namespace palpate {

// Moves from manipulator.home along tool.direction to operator.press.depth beyond the true surface
// (misplacement included) in a minimum-jerk ramp whose peak speed is operator.press.speed, or
// manipulator.max_speed if that is less; a hold of 1 s, or longer, so that it lasts at least a
// third of the contact; the same ramp back; a rest of 0.5 s at home. With an embryo it moves
// straight to the target, independent of the depth.
//
//   p(u) = start + way (10 u^3 - 15 u^4 + 6 u^5),   u = t / T,   peak speed 15/8 |way| / T
//
// Throws std::invalid_argument naming the key if there is no object in front of the tool or home is
// inside the body; see also TrueBody.
PressMotion ScriptedPress(const Scene& scene);

}  // namespace palpate
