#include "tests/stability/simulated_experiment.h"

#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include "slave/capture/simulated_samples.h"
#include "slave/pipeline/fingertips/tactile_estimator.h"
#include "slave/program/progress.h"
#include "slave/study/shape/shape_score.h"
#include "slave/study/shape/virtual_depth_camera.h"

namespace palpate::study {
namespace {

using Eigen::Vector3d;

constexpr double kApart = 0.3;  // of the hand, before the object is pictured alone [s]
constexpr double kStill = 0.5;  // of a hold, before its picture is taken [s]

// The truth and the estimate at one instant. Frame S.
struct Instant {
  SurfaceMesh truth, estimate;
  std::vector<Occluder> fingers;
};

class Experiment {
 public:
  Experiment(const Scene& scene, const ExperimentOptions& options)
      : scene_(scene),
        options_(options),
        simulation_(StartSimulation(scene, {.presses = options.repetitions, .surface = true})),
        estimator_(scene),
        rest_(simulation_->TrueSurface()) {
    object_.name = scene.name;
    static constexpr std::array kNames{"unoccluded", "occluded", "deformed"};
    for (std::size_t k = 0; k < 3; ++k) object_.states[k].name = kNames[k];
  }

  SimulatedObject Run() {
    const double rate = scene_.sense.Find<Tactile>()->rate;
    bool touched = false;
    long apart = 0, still = 0;  // samples
    double depth = 0;
    std::optional<Instant> open;
    std::optional<Instant> before;  // the touch
    const auto fingertips = simulation_->OpenFingertips();
    while (const auto frame = fingertips->Next({})) {
      ReportProgress();
      const ContactEstimate& estimate = estimator_.Estimate(*frame, simulation_->truth().p_S_tip);
      const auto truth = simulation_->truth().fingers;
      const FingerTruth& first = truth[0];
      if (!AnyTouches(truth)) {
        touched = false;
        if (!estimate.force) continue;  // rest values are taken
        before = Now(truth);
        if (++apart == std::lround(kApart * rate)) open = before;
        continue;
      }
      if (!touched && open && before) {
        Take(0, Instant{open->truth, open->estimate, {}});
        Take(1, *before);
      }
      touched = true;
      apart = 0;
      still = std::abs(first.depth - depth) < 1e-9 ? still + 1 : 0;
      depth = first.depth;
      if (still == std::lround(kStill * rate)) {
        Take(2, Now(truth));
        object_.true_force = first.force.norm();
        object_.estimated_force =
            estimate.force ? estimate.force->norm() : std::numeric_limits<double>::quiet_NaN();
        open.reset();
      }
    }
    RequireComplete();
    return std::move(object_);
  }

 private:
  using Truths = std::array<FingerTruth, kMaxFingers>;

  [[nodiscard]] bool AnyTouches(const Truths& truth) const {
    for (std::size_t i = 0; i < scene_.sense.Find<Tactile>()->fingers.size(); ++i) {
      if (truth[i].in_contact) return true;
    }
    return false;
  }

  Instant Now(const Truths& truth) {
    Instant now;
    now.truth = simulation_->TrueSurface();
    now.estimate.triangles = estimator_.body()->surface.triangles;
    now.estimate.nodes = estimator_.object().DeformedNodes();
    for (std::size_t i = 0; i < scene_.sense.Find<Tactile>()->fingers.size(); ++i) {
      now.fingers.push_back(
          FingerCapsule(truth[i].X_SF, scene_.sense.Find<Tactile>()->finger_radius));
    }
    return now;
  }

  // The estimate of who feels nothing.
  [[nodiscard]] SurfaceMesh AtRest() const {
    SurfaceMesh surface = estimator_.body()->surface;
    for (auto& p : surface.nodes) p = estimator_.object().X_SO() * p;
    return surface;
  }

  void Take(std::size_t k, const Instant& instant) {
    ShapeState& state = object_.states[k];
    const DepthCamera& camera = *scene_.sense.depth_camera;
    const auto measured = ScanSurface(camera, instant.truth, instant.fingers, ++seed_);
    const auto simulated = ScanSurface(camera, instant.estimate, instant.fingers, ++seed_);
    state.scores.push_back(Score(measured, simulated, instant.estimate, options_.leaf));
    const auto undeformed = ScanSurface(camera, AtRest(), instant.fingers, seed_);
    state.undeformed.push_back(OctreeScore(measured, undeformed, options_.leaf));
    std::vector<Vector3d> skin;
    state.displacement = 0;
    for (std::size_t i = 0; i < rest_.nodes.size(); ++i) {
      state.displacement =
          std::fmax(state.displacement, (instant.truth.nodes[i] - rest_.nodes[i]).norm());
    }
    for (const auto& triangle : rest_.triangles) {
      for (const int i : triangle) skin.push_back(instant.truth.nodes[static_cast<std::size_t>(i)]);
    }
    state.error = Summarised(DistancesToSurface(skin, instant.estimate));
  }

  void ReportProgress() const {
    const auto contacts = static_cast<double>(object_.states.back().scores.size());
    if (options_.progress && !options_.progress(contacts / options_.repetitions)) {
      throw Interrupted();
    }
  }

  void RequireComplete() const {
    for (const ShapeState& state : object_.states) {
      if (static_cast<int>(state.scores.size()) == options_.repetitions) continue;
      throw std::invalid_argument(scene_.name + ": the " + state.name + " state occurred " +
                                  std::to_string(state.scores.size()) + " times in " +
                                  std::to_string(options_.repetitions) +
                                  " contacts: expected a scene whose fingertips measure forces "
                                  "and both leave and touch the object");
    }
  }

  const Scene& scene_;
  const ExperimentOptions& options_;
  const std::unique_ptr<Simulation> simulation_;
  TactileEstimator estimator_;
  SurfaceMesh rest_;
  SimulatedObject object_;
  std::uint32_t seed_ = 0;
};

}  // namespace

double ShapeState::mean_undeformed() const {
  return std::accumulate(undeformed.begin(), undeformed.end(), 0.0) /
         static_cast<double>(undeformed.size());
}

double ShapeState::mean_octree() const {
  double sum = 0;
  for (const ShapeScore& score : scores) sum += score.octree;
  return sum / static_cast<double>(scores.size());
}

SimulatedObject RunExperiment(const Scene& scene, const ExperimentOptions& options) {
  return Experiment(scene, options).Run();
}

}  // namespace palpate::study
