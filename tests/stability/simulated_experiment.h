// Paper B, IV.C, with simulated contacts, object and camera: the shape estimated from fingertips,
// compared with the truth (figures 10 and 13).
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "slave/scene/scene.h"
#include "slave/study/shape/shape_score.h"

namespace palpate::study {

// One state of the object, as often as it was brought about.
struct ShapeState {
  std::string name;  // unoccluded, occluded, deformed
  // One per repetition; measured: the cloud of the true shape.
  std::vector<ShapeScore> scores;
  std::vector<double> undeformed;  // octree scores of the estimate at rest: of knowing nothing
  DistanceSummary error;           // of the last one: true surface's nodes to the estimate
  double displacement = 0;         // of the true surface, the largest, of the last one [m]

  [[nodiscard]] double mean_octree() const;
  [[nodiscard]] double mean_undeformed() const;
};

struct SimulatedObject {
  std::string name;                            // of the scene
  std::array<ShapeState, 3> states;            // in the order of figure 10
  double true_force = 0, estimated_force = 0;  // first fingertip, last hold [N]; NaN: unknown
};

struct ExperimentOptions {
  int repetitions = 5;  // contacts, at least 1
  double leaf = 0.01;   // [m]
  // Called with the share done; false: stop.
  std::function<bool(double)> progress;
};

// Simulated contacts of the scene; the estimator uses only the tactile samples and the poses of the
// fingertips. Three states of each contact: before it, without the fingers (unoccluded); at the
// last sample before contact (occluded); in the middle of the hold (deformed). The same scene gives
// the same result.
SimulatedObject RunExperiment(const Scene& scene, const ExperimentOptions& options);

}  // namespace palpate::study
