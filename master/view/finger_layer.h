// What the fingertips do to the object, as arrows.
#pragma once

#include <string>

#include "master/haptics/session.h"
#include "master/view/viewpoint.h"
#include "shared/text/svg.h"

namespace palpate {

// A finger at its place in the picture. Its arrow is the force of the finger on the object and ends
// at the place, so that it stands outside and presses in.
struct FingerMark {
  NamedFinger finger;
  Eigen::Vector3d place{0, 0, 0};  // S [m]
};

// The known force of the finger on the object, S [N]; zero: unknown.
Eigen::Vector3d PressOf(const FingerState& finger);
// In words: `0.41 N`, `free`, `force unknown (tracking lost)`.
std::string InWords(const FingerState& finger);

enum class Layer { kBehind, kBefore };  // the object

// Arrows `length` pixels long per newton with their labels, rings for free fingers. Those that come
// from behind the object are painted before it (kBehind), and shine through it (kBefore).
void PaintFingers(const std::vector<FingerMark>& marks, const Viewpoint& view, double length,
                  Layer layer, Svg* drawing);

// An arrow from `tail` to `head`.
void PaintArrow(const Eigen::Vector2d& tail, const Eigen::Vector2d& head, Svg* drawing);

}  // namespace palpate
