// The rig of a simulated pair of cameras, from the keys of its scene.
#pragma once

#include "slave/scene/scene.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

// Returns a rig of two equal lenses without distortion, with principal points at the image's
// centre. The left camera has the pose sense.camera.pose. Both have the same distance d from the
// origin of O, are `baseline` b apart, and are turned towards each other by the vergence 2 asin(b /
// 2d) about y: if the left one looks at the origin of O, so does the right one.
//
// Throws std::invalid_argument naming the key: no pair, numbers out of range, the origin of O not
// in both images.
StereoRig SimulatedRig(const Scene& scene);

}  // namespace palpate
