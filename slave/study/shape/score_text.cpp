#include "slave/study/shape/score_text.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "shared/text/text.h"

namespace palpate::study {
std::string Percent(double share) {
  return std::isfinite(share) ? Formatted("%.1f %%", 100 * share) : "unknown";
}

std::string Millimetres(double length) {
  return std::isfinite(length) ? Formatted("%.1f mm", 1e3 * length) : "unknown";
}

nlohmann::ordered_json DistanceJson(const DistanceSummary& distances) {
  return {{"mean", distances.mean},
          {"rms", distances.rms},
          {"p95", distances.p95},
          {"max", distances.max}};
}

nlohmann::ordered_json ScoreJson(const ShapeScore& score, double leaf) {
  return {{"octree", score.octree},
          {"leaf_m", leaf},
          {"lattices", 8},
          {"measured_points", score.measured},
          {"simulated_points", score.simulated},
          {"measured_to_surface_m", DistanceJson(score.measured_to_surface)},
          {"simulated_to_measured_m", DistanceJson(score.simulated_to_measured)}};
}

}  // namespace palpate::study
