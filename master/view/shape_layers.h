// Layers of a drawing of the shape: the deformed surface as coloured faces, and the forces of the
// fingertips as arrows.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "master/link/remote_mesh.h"
#include "master/session/session.h"
#include "master/view/viewpoint.h"
#include "shared/mesh/solid_mesh.h"
#include "shared/text/svg.h"

namespace palpate {

// Visible outline edges of `surface`: open edges, edges between a triangle that faces the viewer
// and one that does not, and sharp edges (more than 30 degrees) that face the viewer. Returns node
// pairs, the smaller node first, in rising order.
std::vector<std::array<int, 2>> VisibleOutline(const SurfaceMesh& surface, const Viewpoint& view);

// Paints the surface, far faces first. Faces are coloured by displacement, darkest at `full` [m] >
// 0, and lit from the upper left. Triangles of coarse meshes are subdivided for smooth colours.
// Faces toward the viewer are slightly transparent, so that an indentation on the far side is
// visible. Planar objects become a coloured outline.
void PaintSurface(const RemoteMesh& mesh, const Viewpoint& view, double full, Svg* drawing);

// Paints the outline at rest, dashed.
void PaintRest(const MeshTopology& topology, const Viewpoint& view, Svg* drawing);

// A finger in the drawing. Its arrow is the force of the finger on the object, and its head is at
// the contact point.
struct FingerMark {
  NamedFinger finger;
  Eigen::Vector3d place{0, 0, 0};  // S [m]
};

// The known force of the finger on the object, S [N]; zero: unknown.
Eigen::Vector3d PressOf(const FingerState& finger);
// As text: `0.41 N`, `free`, `force unknown (tracking lost)`.
std::string InWords(const FingerState& finger);

enum class Layer { kBehind, kBefore };  // behind or before the object

// Paints arrows of `length` pixels per newton with labels, and rings for free fingers. Arrows
// behind the object are painted first (kBehind), and transparently after it (kBefore).
void PaintFingers(const std::vector<FingerMark>& marks, const Viewpoint& view, double length,
                  Layer layer, Svg* drawing);

// Paints an arrow from `tail` to `head`.
void PaintArrow(const Eigen::Vector2d& tail, const Eigen::Vector2d& head, Svg* drawing);

}  // namespace palpate
