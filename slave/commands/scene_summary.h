// Summarises a scene in one sentence that a person can check without a table.
#pragma once

#include <string>

#include "slave/mechanics/deformation_model.h"
#include "slave/program/plain_modulus.h"
#include "slave/scene/scene.h"
#include "slave/study/press_spec.h"

namespace palpate {

// The answer to the first press of `spec` with this depth [m], as `solve` computes it. `model` is
// the scene's and is unloaded before and afterwards.
ContactResponse PressOnce(const Scene& scene, const study::PressSpec& spec, double depth,
                          DeformationModel* model);

// The sentence states the object's sizes, its stiffness, and the force of the scene's tool at a
// depth of 1 mm, or at the depth of `press` if that is less. `model` is the scene's and is unloaded
// before and afterwards.
std::string SceneSummary(const Scene& scene, const study::PressSpec& press,
                         DeformationModel* model);
// Creates the model itself. The force is omitted for volumes and for `extruded`, whose models take
// long to create; the remarks of the sensing state the force of `extruded`.
std::string SceneSummary(const Scene& scene);

}  // namespace palpate
