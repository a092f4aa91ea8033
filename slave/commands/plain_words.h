// What a scene states, in words and numbers that a person can check without a table.
#pragma once

#include <string>

#include "slave/mechanics/deformation_model.h"
#include "slave/scene/scene.h"
#include "slave/study/press_spec.h"

namespace palpate {

// A familiar thing of about this Young's modulus [Pa]: "a gummy bear".
std::string StiffAs(double young_modulus);
// "0.27 N, the weight of 28 g".
std::string ForceInPlainWords(double newtons);
// One sentence: the object's sizes, its stiffness, and the force of the scene's tool at 1 mm, or at
// the depth of the press where that is less. `model`: the scene's, at rest before and afterwards.
std::string InPlainWords(const Scene& scene, const study::PressSpec& press,
                         DeformationModel* model);
// The same where the model takes no time to make, an outline's or a membrane's; of other objects
// without the force.
std::string InPlainWords(const Scene& scene);
// The same for a modulus alone: the force of a cube of 10 mm, pressed by 1 mm between two plates.
std::string InPlainWords(double young_modulus);

}  // namespace palpate
