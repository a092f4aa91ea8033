#include "slave/simulator/points/scripted_membrane.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <variant>

#include <spdlog/fmt/fmt.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kFineBelow = 1e-3, kCoarseAbove = 50e-3;  // press depths with ten steps [m]

std::vector<double> StepsTo(double depth) {
  const bool ten = depth < kFineBelow || depth > kCoarseAbove;
  const double step = ten ? depth / 10 : ScriptedMembrane::kStep;
  std::vector<double> depths{0};
  for (int k = 1; k * step < depth * (1 - 1e-9); ++k) depths.push_back(k * step);
  depths.push_back(depth);
  return depths;
}

}  // namespace

ScriptedMembrane::ScriptedMembrane(StereoSite& site, const Scene& scene,
                                   const MembraneScript& script)
    : site_(site), rate_(scene.sense.Find<StereoCameras>()->rate) {
  if (!site_.target()) {
    ScriptPress(scene, script);
    return;
  }
  const auto pairs = static_cast<std::size_t>(std::clamp(script.target_seconds * rate_, 1.0, 1e6));
  script_.assign(pairs, {scene.manipulator.home, -1});
}

void ScriptedMembrane::ScriptPress(const Scene& scene, const MembraneScript& script) {
  const Eigen::Isometry3d X_SO = TruePose(scene);
  const Vector3d p_O_home = X_SO.inverse() * scene.manipulator.home;
  const double radius = std::get<MembraneGeometry>(scene.object.geometry).radius;
  if (!(p_O_home.z() > 0 && p_O_home.head<2>().norm() < radius)) {
    throw std::invalid_argument(
        fmt::format("manipulator.home: [{:g}, {:g}, {:g}] m in the membrane's frame: accepted is a "
                    "position above it, z > 0 and less than {:g} m from its axis",
                    p_O_home.x(), p_O_home.y(), p_O_home.z(), radius));
  }
  depths_ = StepsTo(scene.operator_options.press_depth);
  const auto add = [&](int pairs, const Vector3d& p_S_tip, int step) {
    script_.insert(script_.end(), static_cast<std::size_t>(std::max(pairs, 1)), {p_S_tip, step});
  };
  const auto at = [&](double depth) -> Vector3d {
    return X_SO * Vector3d(p_O_home.x(), p_O_home.y(), -depth);
  };
  add(script.rest, scene.manipulator.home, -1);
  for (std::size_t k = 0; k < depths_.size(); ++k) {
    add(script.dwell, at(depths_[k]), static_cast<int>(k));
  }
  for (auto depth = depths_.rbegin() + 1; depth != depths_.rend(); ++depth) add(1, at(*depth), -1);
  add(script.dwell, scene.manipulator.home, -1);
}

std::optional<StereoPair> ScriptedMembrane::Next(const std::stop_token& stop) {
  if (stop.stop_requested() || sequence_ == script_.size()) return std::nullopt;
  const Moment& moment = script_[sequence_];
  site_.MoveTool(moment.p_S_tip);
  StereoPictures pictures = site_.TakePictures();
  StereoPair pair;
  pair.left = std::move(pictures.left);
  pair.right = std::move(pictures.right);
  pair.sensed_at = Time{} + Seconds(static_cast<double>(sequence_) / rate_);
  pair.sequence = ++sequence_;
  return pair;
}

std::string ScriptedMembrane::description() const {
  if (site_.target()) {
    return fmt::format("simulated stereo pair, textured target on its path, {:g} Hz", rate_);
  }
  return fmt::format("simulated stereo pair, scripted contact in {} steps, {:g} Hz",
                     depths_.size() - 1, rate_);
}

}  // namespace palpate
