// The object of a scene with fingertips as it really is: its mesh, where it is held, and the
// fingers around it.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/solid_mesh.h"
#include "shared/scene/scene.h"
#include "slave/site/fingertip/finger_hand.h"
#include "slave/site/fingertip/ladders_ahead.h"
#include "slave/site/fingertip/site_mesh.h"

namespace palpate::site {

struct TrueObject {
  Eigen::Isometry3d X_SO = Eigen::Isometry3d::Identity();  // misplacement included
  FingerHand hand;
  BodyAtRest body;
  SurfaceMesh surface;       // of body.mesh, frame O; its own nodes only
  std::vector<int> node_of;  // surface node to node of body.mesh
};

// Throws std::invalid_argument naming the key: no fingertips, an object that is no volume or held
// nowhere, a fingertip inside it, a first finger that does not move with the hand.
TrueObject MakeTrueObject(const Scene& scene, const SiteResolution& resolution);

}  // namespace palpate::site
