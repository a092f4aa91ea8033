#include "slave/pipeline/points/points_scores.h"

#include <cmath>

#include <nlohmann/json.hpp>

namespace palpate {
namespace {

// Difference of the depths of one halt [m]. [by definition]
constexpr double kSameDepth = 1e-6;
// Pairs of a halt [-]. [by definition]
constexpr int kMinPairs = 3;

}  // namespace

void PressSteps::Add(double depth, double true_force, const std::optional<double>& force) {
  if (steps_.empty() || std::abs(steps_.back().depth - depth) > kSameDepth) {
    steps_.push_back({});
    steps_.back().depth = depth;
    steps_.back().true_force = true_force;
  }
  PressStep& step = steps_.back();
  if (force) {
    ++step.pairs;
    step.force += (*force - step.force) / step.pairs;
    step.force_error = std::fmax(step.force_error, std::abs(*force - true_force));
    for (const Eigen::Vector3d& error : points_) step.displacement.Add(error);
  }
  points_.clear();
}

std::vector<PressStep> PressSteps::steps() const {
  std::vector<PressStep> halts;
  std::size_t way_in = 0;  // number of pairs during the approach
  for (const PressStep& step : steps_) {
    if (step.pairs < kMinPairs) continue;
    halts.push_back(step);
    if (step.depth >= halts[way_in > 0 ? way_in - 1 : 0].depth) way_in = halts.size();
  }
  halts.resize(way_in);
  return halts;
}

nlohmann::ordered_json ToJson(const std::vector<PressStep>& steps) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const PressStep& step : steps) {
    json.push_back({{"depth_m", step.depth},
                    {"pairs", step.pairs},
                    {"true_force_N", step.true_force},
                    {"force_N", step.force},
                    {"force_error_N", step.force_error},
                    {"displacement_error_rms_m", step.displacement.rms()},
                    {"displacement_error_peak_m", step.displacement.peak()}});
  }
  return json;
}

}  // namespace palpate
