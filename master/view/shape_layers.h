// What a picture of the shape is made of: the deformed surface as coloured faces, and what the
// fingertips do to it as arrows.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "master/haptics/session.h"
#include "master/link/remote_mesh.h"
#include "master/view/viewpoint.h"
#include "shared/mesh/solid_mesh.h"
#include "shared/text/svg.h"

namespace palpate {

// The edges by which a person recognises a shape: those of `surface` that the viewer would see of
// it: open ones, those between a triangle that faces the viewer and one that does not, and sharp
// ones (more than 30 degrees) that face the viewer. Node pairs, the smaller first, in rising order.
std::vector<std::array<int, 2>> VisibleOutline(const SurfaceMesh& surface, const Viewpoint& view);

// Far faces first. Coloured by displacement, `full` [m] > 0 being the darkest, and lit from the
// upper left; coarse meshes are painted in parts of a triangle, so that colours run smoothly.
// What faces the viewer shines through a little: a dent on the far side is seen. Planar objects as
// a coloured outline.
void PaintSurface(const RemoteMesh& mesh, const Viewpoint& view, double full, Svg* drawing);

// The outline at rest in dashes.
void PaintRest(const MeshTopology& topology, const Viewpoint& view, Svg* drawing);

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
