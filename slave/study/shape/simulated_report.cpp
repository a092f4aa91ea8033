#include <algorithm>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

#include "shared/text/text.h"
#include "slave/study/shape/score_words.h"
#include "slave/study/shape/simulated_experiment.h"

namespace palpate::study {
namespace {

using Json = nlohmann::ordered_json;

std::string NameOf(const SimulatedObject& object) {
  return object.material.empty() ? object.name : object.name + ", " + object.material;
}

std::pair<double, double> RangeOf(const ShapeState& state) {
  const auto [low, high] = std::ranges::minmax(state.scores, {}, &ShapeScore::octree);
  return {low.octree, high.octree};
}

// By how many points the deformed state scores less than the unoccluded one.
std::string LossOf(const SimulatedObject& object) {
  return Formatted("%+.2f points",
                   100 * (object.states[2].mean_octree() - object.states[0].mean_octree()));
}

std::string Newtons(double force) {
  return std::isfinite(force) ? Formatted("%.3f N", force) : "unknown";
}

std::vector<std::vector<std::string>> Rows(const std::vector<SimulatedObject>& objects) {
  std::vector<std::vector<std::string>> rows;
  for (const SimulatedObject& object : objects) {
    for (const ShapeState& state : object.states) {
      const auto [low, high] = RangeOf(state);
      rows.push_back({NameOf(object), state.name, Percent(state.mean_octree()),
                      Percent(low) + " to " + Percent(high), Percent(state.mean_undeformed()),
                      Millimetres(state.scores.back().measured_to_surface.rms),
                      Millimetres(state.displacement), Millimetres(state.error.mean),
                      Millimetres(state.error.p95), Millimetres(state.error.max)});
    }
  }
  return rows;
}

std::vector<std::string> Head() {
  return {"object",
          "state",
          "octree score",
          "range of repetitions",
          "score of the rest shape",
          "measured to estimate, rms",
          "true deformation",
          "its error, mean",
          "95 %",
          "largest"};
}

Json ToJson(const SimulatedObject& object, double leaf) {
  Json json{{"object", object.name},
            {"material", object.material},
            {"true_force_N", object.true_force},
            {"estimated_force_N", object.estimated_force},
            {"states", Json::array()}};
  for (const ShapeState& state : object.states) {
    Json scores = Json::array();
    for (const ShapeScore& score : state.scores) scores.push_back(ScoreJson(score, leaf));
    json["states"].push_back({{"state", state.name},
                              {"octree_mean", state.mean_octree()},
                              {"undeformed_octree_mean", state.mean_undeformed()},
                              {"true_displacement_max_m", state.displacement},
                              {"true_surface_to_estimate_m", DistanceJson(state.error)},
                              {"repetitions", std::move(scores)}});
  }
  return json;
}

}  // namespace

std::string ToTable(const std::vector<SimulatedObject>& objects) {
  auto rows = Rows(objects);
  rows.insert(rows.begin(), Head());
  std::vector<std::size_t> width(rows.front().size(), 0);
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) width[i] = std::max(width[i], row[i].size());
  }
  std::string table;
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      table.append(row[i]).append(width[i] + 2 - row[i].size(), ' ');
    }
    table.erase(table.find_last_not_of(' ') + 1);
    table += '\n';
  }
  for (const SimulatedObject& object : objects) {
    table += NameOf(object) + ": deformed against unoccluded " + LossOf(object) + ", force " +
             Newtons(object.estimated_force) + " of " + Newtons(object.true_force) + "\n";
  }
  return table;
}

bool WriteSimulated(const std::vector<SimulatedObject>& objects, double leaf,
                    const std::filesystem::path& folder) {
  Json json{{"leaf_m", leaf}, {"objects", Json::array()}};
  for (const SimulatedObject& object : objects) json["objects"].push_back(ToJson(object, leaf));
  return TryWrite(folder / "report.json", json.dump(2) + "\n");
}

}  // namespace palpate::study
