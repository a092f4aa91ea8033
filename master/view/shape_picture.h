// The object as it is deformed now, and what presses it: a picture that a person understands at a
// glance.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "master/haptics/session.h"
#include "master/link/remote_mesh.h"

namespace palpate {

// What is seen of a run at one moment.
struct ShapeMoment {
  std::string scene;                       // its name
  double t = 0;                            // [s] since the run began
  std::shared_ptr<const RemoteMesh> mesh;  // never null
  std::vector<NamedFinger> fingers;
  std::vector<Eigen::Vector3d> homes;  // where the fingertips were at home, S [m]; may be empty
};

// As SVG: the deformed surface, coloured by how far it moved, the outline at rest in dashes, an
// arrow at each finger that touches (force of the fingertip on the object, its head at the place),
// a ring where one is free, scales for newtons and millimetres. Volumes are seen from aside, turned
// so that the line between the first two fingers, or from the object to the only one, lies across;
// planar objects from the front. The view depends on the object at rest only and stands still.
std::string DrawShape(const ShapeMoment& moment);

// Where the place that `finger` touches on the object at rest is now, S [m]: it moves with the
// surface. A free finger is where it is.
Eigen::Vector3d PlaceNow(const FingerState& finger, const RemoteMesh& mesh);

}  // namespace palpate
