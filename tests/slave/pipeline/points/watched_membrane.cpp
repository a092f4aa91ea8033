#include "tests/slave/pipeline/points/watched_membrane.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <stdexcept>
#include <thread>

#include <opencv2/core.hpp>
#include <unistd.h>

#include "slave/pipeline/points/surface_point_tracker.h"
#include "slave/scene/scene_loader.h"
#include "slave/vision/dots/dot_layout.h"
#include "tests/slave/vision/dots/dot_images.h"

namespace palpate::testing_fakes {
namespace {

constexpr double kWatchedRadius = 0.039, kWatchedThickness = 0.0035;  // [m]
constexpr double kWatchedYoung = 27.2e6, kWatchedPoisson = 0.45;      // [Pa], [-]
constexpr double kDotRadius = 0.002;                                  // [m]
constexpr auto kWatchPeriod = std::chrono::milliseconds(5);

constexpr int kPairs = 8;  // so that the rest frame's noise is averaged
Eigen::Vector3d Normal(const Press& press, const Eigen::Vector2d& p) {
  constexpr double kStep = 1e-5;  // [m]
  const auto w = [&](double dx, double dy) {
    return PlateDeflection(press.force, press.p_O, p + Eigen::Vector2d(dx, dy));
  };
  return Eigen::Vector3d((w(kStep, 0) - w(-kStep, 0)) / (2 * kStep),
                         (w(0, kStep) - w(0, -kStep)) / (2 * kStep), 1)
      .normalized();
}

}  // namespace

Scene WatchedMembraneScene(const std::string& points, const std::string& model) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("membrane-scene-" + std::to_string(getpid()) + ".yaml");
  std::ofstream(file)
      << "name: membrane\n"
         "object:\n"
         "  geometry: {membrane: {radius: 39 mm, thickness: 3.5 mm}}\n"
         "  material: {young_modulus: 27.2 MPa, poisson_ratio: 0.45}\n"
         "  fixed: {side: rim}\n"
         "tool: {shape: round, width: 3.5 mm}\n"
         "sense:\n"
         "  camera: {source: simulated, rate: 30 Hz, size: [640, 480], pair: {baseline: 60 mm, "
         "focal: 800 px}}\n"
         "  points: {"
      << points << "}\nmodel: {" << model << "}\n";
  Scene scene = LoadScene(file);
  scene.tool->width = 1e-3;  // the drawn load is a point's, narrower than a simulated site's tools
  std::filesystem::remove(file);
  return scene;
}

double PlateDeflection(double force, const Eigen::Vector2d& p_O_load, const Eigen::Vector2d& p_O) {
  const double a2 = kWatchedRadius * kWatchedRadius, p2 = p_O_load.squaredNorm(),
               r2 = p_O.squaredNorm();
  if (r2 >= a2) return 0;
  const double along = p_O.dot(p_O_load);
  const double R1 = r2 + p2 - 2 * along, R2 = a2 + r2 * p2 / a2 - 2 * along;  // squares
  const double logarithm = R1 > 0 ? R1 * std::log(R1 / R2) : 0;
  return 3 * force * (1 - kWatchedPoisson * kWatchedPoisson) /
         (4 * std::numbers::pi * kWatchedYoung * std::pow(kWatchedThickness, 3)) *
         ((a2 - p2) * (a2 - r2) / a2 + logarithm);
}

StereoPair DotPairs::Draw(const Press& press, std::uint64_t seed) const {
  std::vector<Eigen::Vector3d> places, normals;
  for (const Eigen::Vector2d& p : LatticePlaces(31, {0.015, 0.010})) {
    places.emplace_back(p.x(), p.y(), -PlateDeflection(press.force, press.p_O, p));
    normals.push_back(Normal(press, p));
  }
  StereoPair pair;
  for (const int eye : {0, 1}) {
    DotImage image;
    if (!(press.covered && eye == 0)) image.dots = ArraySeen(eye, places, normals, kDotRadius);
    (eye == 0 ? pair.left : pair.right) = image.Render(2 * seed + static_cast<std::uint64_t>(eye));
  }
  return pair;
}

void MembraneEnvironment::Show(const Press& press) {
  std::vector<StereoPair> pairs;
  for (int i = 0; i < kPairs; ++i) pairs.push_back(DotPairs().Draw(press, ++drawn_));
  const std::lock_guard lock(mutex_);
  pairs_ = std::move(pairs);
  silent_ = false;
}

void MembraneEnvironment::FallSilent() {
  const std::lock_guard lock(mutex_);
  silent_ = true;
}

void MembraneEnvironment::End() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
}

void MembraneEnvironment::Break() {
  const std::lock_guard lock(mutex_);
  broken_ = true;
}

std::optional<StereoPair> MembraneSource::Next(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::this_thread::sleep_for(kWatchPeriod);
    const std::lock_guard lock(environment_->mutex_);
    if (environment_->broken_) throw std::runtime_error("the cable is off");
    if (environment_->ended_) break;
    if (environment_->silent_) continue;
    StereoPair pair = environment_->pairs_[sequence_ % environment_->pairs_.size()];
    pair.sequence = ++sequence_;
    // A real camera never shows exactly the same image twice, so noise is added.
    cv::RNG noise(sequence_);
    for (cv::Mat* image : {&pair.left, &pair.right}) {
      cv::Mat levels(image->size(), image->type());
      noise.fill(levels, cv::RNG::UNIFORM, 0, 2);
      *image = *image + levels;
    }
    pair.sensed_at = Clock::now();
    return pair;
  }
  return std::nullopt;
}

}  // namespace palpate::testing_fakes
