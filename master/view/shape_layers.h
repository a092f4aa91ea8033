// Layers of a drawing of the shape: the deformed surface as coloured faces, and the forces of the
// fingertips as arrows.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "master/link/remote_mesh.h"
#include "master/session/session.h"
#include "shared/mesh/solid_mesh.h"
#include "shared/text/svg.h"

namespace palpate {

// A parallel projection of frame S [m] into pixels, y down.
class Viewpoint {
 public:
  // From above and slightly from the side, z up, with `along` across the view. A vector that is
  // nearly vertical, zero or not finite counts as x.
  static Viewpoint Across(const Eigen::Vector3d& along);
  // x to the right, y up, for planar scenes.
  static Viewpoint Front();

  // Scales and shifts so that `points` fill the rectangle [px] and are centred in it.
  void Fit(std::span<const Eigen::Vector3d> points, const Eigen::Vector2d& corner,
           const Eigen::Vector2d& size);

  [[nodiscard]] Eigen::Vector2d ToPicture(const Eigen::Vector3d& p_S) const {
    return origin_ + scale_ * Across2d(p_S);
  }
  // A direction without the origin, `length` pixels per unit.
  [[nodiscard]] Eigen::Vector2d Direction(const Eigen::Vector3d& v_S, double length) const {
    return length * Across2d(v_S);
  }
  // Larger values are nearer to the viewer.
  [[nodiscard]] double Nearness(const Eigen::Vector3d& v_S) const { return toward_.dot(v_S); }
  [[nodiscard]] double scale() const { return scale_; }  // [px/m]

 private:
  Viewpoint(const Eigen::Vector3d& right, const Eigen::Vector3d& up, const Eigen::Vector3d& toward)
      : right_(right), up_(up), toward_(toward) {}
  [[nodiscard]] Eigen::Vector2d Across2d(const Eigen::Vector3d& v) const {
    return {right_.dot(v), -up_.dot(v)};
  }

  Eigen::Vector3d right_, up_, toward_;  // orthonormal, S
  Eigen::Vector2d origin_{0, 0};         // [px]
  double scale_ = 1;                     // [px/m]
};

// Round end of a scale: the least 1, 2, 4, 6 or 8 times a power of ten that is at least `value` > 0
// and at least `floor` > 0.
double RoundedUp(double value, double floor);

// Colour of `share` of a scale, 0 (pale) to 1 (dark), under `light`, 0 (dark) to 1, as `#rrggbb`.
std::string ColourOf(double share, double light = 1);

// `value` with three significant digits: 0.412, 12.5, 1e+06.
std::string Readable(double value);

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
