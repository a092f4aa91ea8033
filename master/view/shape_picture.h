// A drawing of the deformed object with the forces on it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "master/link/remote_mesh.h"
#include "master/session/session.h"

namespace palpate {

// Data of one drawing.
struct ShapeMoment {
  std::string scene;                       // its name
  double t = 0;                            // [s] since the run began
  std::shared_ptr<const RemoteMesh> mesh;  // never null
  std::vector<NamedFinger> fingers;
  std::vector<Eigen::Vector3d> homes;  // home positions of the fingertips, S [m]; may be empty
};

// Draws an SVG: the deformed surface, coloured by displacement, the outline at rest dashed, an
// arrow at each finger in contact (force of the fingertip on the object, head at the contact
// point), a ring at each free finger, and scales in newtons and millimetres. Volumes are shown from
// the side, so that the line between the first two fingers, or from the object to the only one, is
// horizontal. Planar objects are shown from the front. The view depends only on the object at rest.
std::string DrawShape(const ShapeMoment& moment);

// Present position of the contact point of `finger`, S [m]: it moves with the surface. For a free
// finger it is the position of the finger.
Eigen::Vector3d PlaceNow(const FingerState& finger, const RemoteMesh& mesh);

}  // namespace palpate
