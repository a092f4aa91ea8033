// Paper B, IV.C, with simulated contacts, object and camera: the shape estimated from fingertips,
// compared with the truth (figures 10 and 13).
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "slave/scene/scene.h"
#include "slave/study/shape/shape_score.h"

namespace palpate::study {

// The paper's foams (table III; Poisson's ratio from the authors' material files).
struct Foam {
  std::string_view name;
  double young_modulus, density;  // [Pa], [kg/m^3]
};
inline constexpr double kFoamPoissonRatio = 0.15;
inline constexpr std::array<Foam, 3> kFoams{
    {{"hard", 3800, 45}, {"medium", 3200, 30}, {"soft", 3000, 26}}};
// The scene with its object made of another foam.
Scene MadeOf(const Foam& foam, const Scene& scene);

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
  std::string material;                        // of kFoams, or empty
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
// the same result. Throws std::invalid_argument: not simulated fingertips, no sense.depth_camera,
// scenes that palpate-simulator and
// TactileEstimator reject; Interrupted.
SimulatedObject RunExperiment(const Scene& scene, const ExperimentOptions& options);

// One line per object and state: octree score with its spread, distances.
std::string ToTable(const std::vector<SimulatedObject>& objects);
// Writes report.json. False: cannot be written.
bool WriteSimulated(const std::vector<SimulatedObject>& objects, double leaf,
                    const std::filesystem::path& folder);

}  // namespace palpate::study
