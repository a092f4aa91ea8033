// What a scene states, in words and numbers that a person can check without a table.
#pragma once

#include <string>

#include "slave/identify/plain_modulus.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/scene/scene.h"
#include "slave/study/press_spec.h"

namespace palpate {

// One sentence: the object's sizes, its stiffness, and the force of the scene's tool at 1 mm, or at
// the depth of the press where that is less. `model`: the scene's, at rest before and afterwards.
std::string InPlainWords(const Scene& scene, const study::PressSpec& press,
                         DeformationModel* model);
// The same where the model takes no time to make, an outline's or a membrane's; of other objects
// without the force.
std::string InPlainWords(const Scene& scene);

}  // namespace palpate
