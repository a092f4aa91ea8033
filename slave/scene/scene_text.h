// Descriptions for people: lengths with a readable unit, geometries.
#pragma once

#include <string>

#include "slave/scene/scene.h"

namespace palpate {

std::string LengthInWords(double metres);
std::string InWords(const Geometry& geometry);
std::string InWords(const Region& region);

}  // namespace palpate
