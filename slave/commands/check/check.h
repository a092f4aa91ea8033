// The parts of `check`, and how it prints: a label and a sentence, lengths with a readable unit.
#pragma once

#include <string>

#include "slave/mechanics/deformation_model.h"
#include "slave/scene/scene.h"

namespace palpate {

void PrintLine(const std::string& what, const std::string& text);
std::string LengthInWords(double metres);
std::string InWords(const Geometry& geometry);
// Name, object and material.
void PrintObject(const Scene& scene);
std::string InWords(const Camera& camera);
// Two eyes or a depth camera: from where; of two that run freely when they are a pair.
void PrintCameras(const Scene& scene);
// Whether a real arm moves what live pictures show.
bool ShowsArm(const Scene& scene);
// The arm, and what it is a witness of.
void PrintManipulator(const Scene& scene);
// Scales and limit of the operator's hand.
void PrintHand(const Scene& scene);

// The model that runs and why; of `model.kind: auto` also what was rejected, with its figures.
void PrintChoice(const Scene& scene);

// What the deformed shape costs while somebody watches it: measured on the last answer.
void PrintShapeCost(DeformationModel& model);

// Of membranes and volumes: prints the object, its mesh and the mesh's quality, the model and a
// press. Throws std::invalid_argument: the scene cannot be computed.
void PrintBody(const Scene& scene);
// The same as the report of a scene without senses.
void CheckBody(const Scene& scene);

// Prints the report of a scene with two cameras or depth pictures: where they stand, what they see,
// how exact and how fast. Throws std::invalid_argument or std::runtime_error: the scene cannot be
// seen or computed.
void CheckStereo(const Scene& scene);

// Prints the report of a scene with fingertips: what senses, what it tells, how exact and how fast.
// Throws std::invalid_argument or std::runtime_error: the scene cannot be sensed
// or computed.
void CheckTactile(const Scene& scene);

}  // namespace palpate
