// The shape that a scene's model gives its object, for `evaluate`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "shared/mesh/solid_mesh.h"
#include "shared/text/progress.h"
#include "slave/scene/scene.h"
#include "slave/study/shape/virtual_depth_camera.h"

namespace palpate {

struct EstimatedShape {
  SurfaceMesh rest_S, estimate_S;          // same nodes and triangles
  std::string state;                       // in words, how the estimate came about
  std::vector<study::Occluder> fingers_S;  // that stand in the camera's view
};

// The object's surface under the rows of both tables (as `solve` reads them; paths may be empty:
// none), all of which act together; without any, at rest. Throws what `solve` throws for tables;
// std::invalid_argument: an object that is no volume, a model that gives no answer.
EstimatedShape ShapeUnderTables(const Scene& scene, const std::filesystem::path& contacts,
                                const std::filesystem::path& loads, Progress* progress);

// The surface at the end of the scene's tactile recording, as its fingertips tell it; at rest if
// the scene has none or nobody says where its fingertips are. Throws what OpenTactileRecording and
// TactileEstimator throw; Interrupted.
EstimatedShape ShapeAfterRecording(const Scene& scene, Progress* progress);

}  // namespace palpate
