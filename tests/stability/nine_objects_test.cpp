// Paper B, IV.C and figure 13: three shapes in three foams, each seen unoccluded, occluded by the
// fingers that touch it, and deformed by them. In the paper the sponge had a lower score; here all
// must pass.
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include "slave/capture/simulated_samples.h"
#include "slave/pipeline/fingertips/tactile_estimator.h"
#include "slave/scene/scene_loader.h"
#include "slave/study/shape/shape_score.h"
#include "slave/study/shape/virtual_depth_camera.h"
#include "tests/support/paths.h"

namespace palpate::study {
namespace {

namespace fs = std::filesystem;

using Eigen::Vector3d;

// Time without contact before the object is imaged without fingers [s].
constexpr double kApart = 0.3;
constexpr double kStill = 0.5;  // time of a hold before its image [s]
constexpr double kLeaf = 0.01;  // of the octree [m]

// The truth and the estimate at one instant. Frame S.
struct Instant {
  SurfaceMesh truth, estimate;
  std::vector<Occluder> fingers;
};

// Results of all contacts that produced the same state of the object.
struct ShapeState {
  std::vector<ShapeScore> scores;  // one per contact; measured: the cloud of the true shape
  DistanceSummary error;           // of the last one: true surface's nodes to the estimate
  double displacement = 0;         // of the true surface, the largest, of the last one [m]

  [[nodiscard]] double mean_octree() const {
    double sum = 0;
    for (const ShapeScore& score : scores) sum += score.octree;
    return sum / static_cast<double>(scores.size());
  }
};

// Unoccluded, occluded, deformed: in the order of figure 10.
using ShapeStates = std::array<ShapeState, 3>;

// Simulated contacts of the scene; the estimator uses only the tactile samples and the poses of the
// fingertips. Three states of each contact: before it, without the fingers (unoccluded); at the
// last sample before contact (occluded); in the middle of the hold (deformed). The same scene gives
// the same result.
class Experiment {
 public:
  Experiment(const Scene& scene, int contacts)
      : tactile_(*scene.sense.Find<Tactile>()),
        camera_(*scene.sense.depth_camera),
        simulation_(StartSimulation(scene, {.presses = contacts, .surface = true})),
        estimator_(scene),
        rest_(simulation_->TrueSurface()) {}

  ShapeStates Run() {
    const double rate = tactile_.rate;
    bool touched = false;
    long apart = 0, still = 0;  // samples
    double depth = 0;
    std::optional<Instant> open;
    std::optional<Instant> before;  // the touch
    const auto fingertips = simulation_->OpenFingertips();
    while (const auto frame = fingertips->Next({})) {
      const ContactEstimate& estimate = estimator_.Estimate(*frame, simulation_->truth().p_S_tip);
      const auto truth = simulation_->truth().fingers;
      const FingerTruth& first = truth[0];
      if (!AnyTouches(truth)) {
        touched = false;
        if (!estimate.force) continue;  // the baseline is being measured
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
        open.reset();
      }
    }
    return states_;
  }

 private:
  using Truths = std::array<FingerTruth, kMaxFingers>;

  [[nodiscard]] bool AnyTouches(const Truths& truth) const {
    for (std::size_t i = 0; i < tactile_.fingers.size(); ++i) {
      if (truth[i].in_contact) return true;
    }
    return false;
  }

  Instant Now(const Truths& truth) {
    Instant now;
    now.truth = simulation_->TrueSurface();
    now.estimate.triangles = estimator_.body()->surface.triangles;
    now.estimate.nodes = estimator_.object().DeformedNodes();
    for (std::size_t i = 0; i < tactile_.fingers.size(); ++i) {
      now.fingers.push_back(FingerCapsule(truth[i].X_SF, tactile_.finger_radius));
    }
    return now;
  }

  void Take(std::size_t k, const Instant& instant) {
    ShapeState& state = states_[k];
    const auto measured = ScanSurface(camera_, instant.truth, instant.fingers, ++seed_);
    const auto simulated = ScanSurface(camera_, instant.estimate, instant.fingers, ++seed_);
    state.scores.push_back(Score(measured, simulated, instant.estimate, kLeaf));
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

  const Tactile& tactile_;
  const DepthCamera& camera_;
  const std::unique_ptr<Simulation> simulation_;
  TactileEstimator estimator_;
  SurfaceMesh rest_;
  ShapeStates states_;
  std::uint32_t seed_ = 0;
};

// The paper's foams (table III; Poisson's ratio from the authors' material files).
struct Foam {
  std::string_view name;
  double young_modulus, density;  // [Pa], [kg/m^3]
};
constexpr Foam kFoams[] = {{"hard", 3800, 45}, {"medium", 3200, 30}, {"soft", 3000, 26}};

class NineObjects : public testing::TestWithParam<std::tuple<std::string, Foam>> {};

// The true shape is a neo-Hookean body on a separate finer mesh; the estimate uses tactile samples
// and the fingertips' poses. Tolerances: two points of the octree score; 95 % of the surface within
// a third of the indentation, and the mean within a tenth, since elements of 10 mm cannot resolve
// more under fingertips of 7 mm.
TEST_P(NineObjects, DeformedShapeScoresWithinTwoPointsOfTheUnoccludedOne) {
  const auto& [name, foam] = GetParam();
  const fs::path file = fs::path(SourcePath()) / "deploy/scenes" / ("foam-" + name + ".yaml");
  const Scene scene =
      LoadScene(file, {fmt::format("object.material.young_modulus={} Pa", foam.young_modulus),
                       fmt::format("object.material.density={} kg/m3", foam.density),
                       "object.material.poisson_ratio=0.15"});
  constexpr int kContacts = 2;
  const ShapeStates states = Experiment(scene, kContacts).Run();
  for (const auto& state : states) ASSERT_EQ(static_cast<int>(state.scores.size()), kContacts);
  const auto& [unoccluded, occluded, deformed] = states;
  EXPECT_GE(deformed.mean_octree(), unoccluded.mean_octree() - 0.02);
  EXPECT_GE(occluded.mean_octree(), unoccluded.mean_octree() - 0.02);
  const double press = scene.operator_options.press_depth;
  EXPECT_GT(deformed.displacement, 0.9 * press);
  EXPECT_LT(deformed.error.p95, press / 3);
  EXPECT_LT(deformed.error.mean, press / 10);
  fmt::print("{}, {}: octree score {:.2f} % unoccluded, {:.2f} % deformed\n", name, foam.name,
             100 * unoccluded.mean_octree(), 100 * deformed.mean_octree());
}

std::string InWords(const testing::TestParamInfo<NineObjects::ParamType>& object) {
  return std::get<0>(object.param) + "_" + std::string(std::get<1>(object.param).name);
}

INSTANTIATE_TEST_SUITE_P(Scenes, NineObjects,
                         testing::Combine(testing::Values("cube", "sponge", "bar"),
                                          testing::ValuesIn(kFoams)),
                         InWords);

}  // namespace
}  // namespace palpate::study
