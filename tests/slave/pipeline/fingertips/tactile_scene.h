// Scenes with fingertips for tests, and the readings of their fingertips.
#pragma once

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <unistd.h>

#include "slave/pipeline/fingertips/tactile_estimator.h"
#include "slave/scene/scene_loader.h"
#include "tests/slave/tactile/fakes.h"

namespace palpate::testing_fakes {

inline constexpr int kRest = 5, kWindow = 5;

// A cube of foam, 40 mm, on the table; `tactile` holds the keys of sense.tactile but the source.
inline Scene CubeScene(const std::string& tactile, const std::string& model = "kind: fem",
                       const std::string& pose = "{}") {
  const auto file = std::filesystem::temp_directory_path() /
                    ("tactile-scene-" + std::to_string(getpid()) + ".yaml");
  std::ofstream(file)
      << "name: cube\n"
         "object:\n"
         "  geometry: {box: {size: [40 mm, 40 mm, 40 mm], cells: [4, 4, 4]}}\n"
         "  pose: "
      << pose
      << "\n"
         "  material: {young_modulus: 4 kPa, poisson_ratio: 0.15, density: 45 kg/m3}\n"
         "  fixed: {plane: {axis: z, at: 0 mm}}\n"
         "sense: {tactile: {source: stream, rest: first 5, "
      << tactile
      << "}}\n"
         "model: {"
      << model << "}\n";
  Scene scene = LoadScene(file);
  std::filesystem::remove(file);
  return scene;
}

// A fingertip flat above the centre of the top: its pad touches at z = 40 mm.
inline const std::string kAbove = "pose: {translation: [20 mm, 20 mm, 47 mm]}";

inline TactileSenses Fakes(int window = kWindow) {
  return {std::make_shared<MeanNetwork>(window), std::make_shared<PadLocaliser>()};
}

// Frames of fingertips with given counts.
class Hand {
 public:
  explicit Hand(std::size_t fingers)
      : forces_F(fingers, Eigen::Vector3d::Zero()), active(fingers) {}

  TactileFrame Next() {
    TactileFrame frame;
    frame.sequence = ++sequence_;
    frame.sensed_at = Time{} + Seconds(0.01 * static_cast<double>(sequence_));
    for (std::size_t i = 0; i < forces_F.size(); ++i) {
      frame.fingers[i] = ReadingOf(forces_F[i], active[i]);
    }
    return frame;
  }

  std::vector<Eigen::Vector3d> forces_F;  // of the fingertips on the object [N]
  std::vector<bool> active;

 private:
  std::uint64_t sequence_ = 0;
};

// A scene, its estimator, and fingertips that rested.
struct Touching {
  explicit Touching(const Scene& scene_in)
      : scene(scene_in),
        estimator(scene, Fakes()),
        hand(scene.sense.Find<Tactile>()->fingers.size()) {
    Estimate(kRest + kWindow);
  }
  const ContactEstimate& Estimate(int samples, const Eigen::Vector3d& way = {0, 0, 0}) {
    for (int i = 0; i < samples; ++i) {
      estimator.Estimate(hand.Next(), scene.manipulator.home + way);
    }
    return estimator.estimate();
  }
  const ContactEstimate& Press(const Eigen::Vector3d& force_F, const Eigen::Vector3d& way,
                               std::size_t finger = 0, int samples = kWindow) {
    hand.forces_F[finger] = force_F;
    hand.active[finger] = true;
    return Estimate(samples, way);
  }
  [[nodiscard]] std::vector<Eigen::Vector3d> Nodes() const {
    return estimator.object().DeformedNodes();
  }
  [[nodiscard]] double LargestMove() {
    const std::vector<Eigen::Vector3d> p_S = Nodes();
    double largest = 0;
    for (std::size_t i = 0; i < p_S.size(); ++i) {
      const Eigen::Vector3d rest = estimator.object().X_SO() * estimator.body()->surface.nodes[i];
      largest = std::fmax(largest, (p_S[i] - rest).norm());
    }
    return largest;
  }

  Scene scene;
  TactileEstimator estimator;
  Hand hand;
};

inline constexpr const char* kFive =
    "fingers: {a: {pose: {translation: [20 mm, 20 mm, 47 mm]}},"
    " b: {pose: {translation: [8 mm, 10 mm, 47 mm]}},"
    " c: {pose: {translation: [47 mm, 20 mm, 25 mm], rotation: [0, 90 deg, 0]}},"
    " d: {pose: {translation: [-7 mm, 21 mm, 20 mm], rotation: [0, -90 deg, 0]}},"
    " e: {pose: {translation: [33 mm, 30 mm, 47 mm]}, motion: stands}}";

}  // namespace palpate::testing_fakes
