#include "slave/study/shape/report_words.h"

#include <cmath>
#include <cstdio>
#include <fstream>

#include <nlohmann/json.hpp>

namespace palpate::study {
namespace {

using Json = nlohmann::ordered_json;

std::string Text(const char* format, double value) {
  if (!std::isfinite(value)) return "unknown";
  char text[40];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

Json NumberOrNull(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

}  // namespace

std::string Percent(double share) {
  return Text("%.1f %%", 100 * share);
}

std::string Millimetres(double length) {
  return Text("%.1f mm", 1e3 * length);
}

std::string LabelWords(const LabelScore& label) {
  return label.support ? "support" : Percent(label.iou);
}

std::vector<std::string> DistanceHead(std::string first) {
  return {std::move(first), "mean", "rms", "95 %", "largest"};
}

std::vector<std::string> DistanceRow(std::string name, const DistanceSummary& distances) {
  return {std::move(name), Millimetres(distances.mean), Millimetres(distances.rms),
          Millimetres(distances.p95), Millimetres(distances.max)};
}

Json DistanceJson(const DistanceSummary& distances) {
  return {{"mean", NumberOrNull(distances.mean)},
          {"rms", NumberOrNull(distances.rms)},
          {"p95", NumberOrNull(distances.p95)},
          {"max", NumberOrNull(distances.max)}};
}

Json ScoreJson(const ShapeScore& score, double leaf) {
  return {{"octree", NumberOrNull(score.octree)},
          {"leaf_m", leaf},
          {"lattices", 8},
          {"measured_points", score.measured},
          {"simulated_points", score.simulated},
          {"measured_to_surface_m", DistanceJson(score.measured_to_surface)},
          {"simulated_to_measured_m", DistanceJson(score.simulated_to_measured)}};
}

bool WriteText(const std::filesystem::path& file, std::string_view text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  return static_cast<bool>(stream.flush());
}

}  // namespace palpate::study
