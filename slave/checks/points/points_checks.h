// The checks of a stereo pair or depth camera: of the points, before a load is fitted to them.
#pragma once

#include "slave/checks/check.h"
#include "slave/checks/points/points_sample.h"
#include "slave/scene/scene.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

// `rig`: unused for depth images.
Checks<PointsSample> MakePointsChecks(const Scene& scene, const StereoRig& rig);

}  // namespace palpate
