// How `check` prints: a label and a sentence, lengths with a readable unit.
#pragma once

#include <string>

#include "slave/scene/scene.h"

namespace palpate {

void PrintLine(const std::string& what, const std::string& text);
std::string LengthInWords(double metres);
std::string InWords(const Geometry& geometry);
// Name, object and material.
void PrintObject(const Scene& scene);
// Scales and limit of the operator's hand.
void PrintHand(const Scene& scene);

}  // namespace palpate
