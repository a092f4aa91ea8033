// `palpate-slave evaluate`: the estimated shape against a measured cloud, or against the truth of a
// simulated site (contracts; paper B, IV.C).
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "shared/mesh/solid_mesh.h"
#include "shared/text/progress.h"
#include "slave/scene/scene.h"
#include "slave/study/shape/virtual_depth_camera.h"

namespace palpate {

struct EvaluateOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;  // key.path=value
  std::filesystem::path cloud;         // PCD, frame of the camera; empty: the simulated experiment
  std::filesystem::path out;           // folder
  std::filesystem::path contacts, loads;  // CSV as for `solve`; empty: what fingertips tell
  std::string segment = "surfaces";       // surfaces colour no
  std::vector<double> at;   // x, y, z of a point on the object, frame of the camera [m]
  std::vector<int> colour;  // red, green, blue of the object
  double voxel = 0;         // [m]; 0: by the cloud
  int neighbours = 30;      // of a point, for growing by colour
  double point_colour = 20, region_colour = 10;  // largest differences [0 to 442]
  double leaf = 0.01;                            // of the octree [m]
  int repetitions = 5;                           // presses of the simulated experiment
  bool materials = false;                        // it is made with each of the paper's three foams
};

// Returns the exit code: 0 done, 1 the files cannot be written or nothing of the cloud could be
// scored. Throws SceneError, InputError, std::invalid_argument: what is unusable.
int RunEvaluate(const EvaluateOptions& options, const std::stop_token& stop);

// The shape that a scene's model gives its object.
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

}  // namespace palpate
