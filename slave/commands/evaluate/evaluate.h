// `palpate-slave evaluate`: compares the estimated shape with a measured cloud (paper B,
// IV.C).
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "slave/program/progress.h"
#include "slave/scene/scene.h"
#include "slave/study/shape/measured_evaluation.h"

namespace palpate {

struct EvaluateOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;  // key.path=value
  std::filesystem::path cloud;         // PCD, frame of the camera
  std::filesystem::path out;           // folder
  std::filesystem::path contacts,
      loads;  // CSV as for `solve`; both empty: the estimate from the fingertips
  std::string segment = "surfaces";  // separation of the object: surfaces, colour or no
  std::vector<double> at;            // x, y, z of a point on the object, frame of the camera [m]
  double leaf = 0.01;                // of the octree [m]
};

// Returns the exit code: 0 done, 1 the files cannot be written or the cloud has no score. Throws
// SceneError, InputError, std::invalid_argument: unusable input.
int RunEvaluate(const EvaluateOptions& options, const std::stop_token& stop);

// Computes the object's surface under the rows of both tables together (read as by `solve`; an
// empty path: no rows). Without rows it is at rest. Throws as `solve` for invalid tables;
// std::invalid_argument: an object that is not a volume, a model without a solution.
study::EstimatedShape ShapeUnderTables(const Scene& scene, const std::filesystem::path& contacts,
                                       const std::filesystem::path& loads, Progress* progress);

}  // namespace palpate
