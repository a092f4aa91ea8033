#include "slave/study/shape/simulated_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include <nlohmann/json.hpp>

#include "slave/study/shape/html_page.h"
#include "slave/study/shape/report_words.h"
#include "slave/study/shape/shape_pictures.h"

namespace palpate::study {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kTurn = -0.4;  // by which one looks past the leaves [rad]

std::string NameOf(const SimulatedObject& object) {
  return object.material.empty() ? object.name : object.name + ", " + object.material;
}

std::pair<double, double> RangeOf(const ShapeState& state) {
  const auto [low, high] = std::ranges::minmax(state.scores, {}, &ShapeScore::octree);
  return {low.octree, high.octree};
}

// By how many points the deformed state scores less than the unoccluded one.
std::string LossOf(const SimulatedObject& object) {
  char text[40];
  std::snprintf(text, sizeof text, "%+.2f points",
                100 * (object.states[2].mean_octree() - object.states[0].mean_octree()));
  return text;
}

std::string Newtons(double force) {
  if (!std::isfinite(force)) return "unknown";
  char text[40];
  std::snprintf(text, sizeof text, "%.3f N", force);
  return text;
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

const std::vector<std::string>& Head() {
  static const std::vector<std::string> head{"object",
                                             "state",
                                             "octree score",
                                             "of the repetitions",
                                             "of the shape at rest",
                                             "measured to estimate, rms",
                                             "true deformation",
                                             "its error, mean",
                                             "95 %",
                                             "largest"};
  return head;
}

Json ToJson(const SimulatedObject& object, double leaf) {
  Json json{{"object", object.name},
            {"material", object.material},
            {"true_force_N", object.true_force},
            {"estimated_force_N",
             std::isfinite(object.estimated_force) ? Json(object.estimated_force) : Json(nullptr)},
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

std::vector<HtmlPage::Figure> Figures(const SimulatedObject& object, const DepthCamera& camera,
                                      double leaf) {
  std::vector<HtmlPage::Figure> figures;
  // One view for all states, so that they can be compared.
  const PictureView aside = ViewOf(camera.X_SD, object.states[0].estimate_S.nodes, kTurn);
  for (const ShapeState& state : object.states) {
    figures.push_back({PictureOfShapes(aside, state.measured_S, state.estimate_S, state.fingers_S),
                       NameOf(object) + ", " + state.name +
                           ": measured points, near ones dark, and the estimate's mesh"});
    figures.push_back(
        {PictureOfLeaves(aside, state.measured_S, state.simulated_S, leaf),
         NameOf(object) + ", " + state.name + ": octree score " +
             Percent(state.scores.back().octree) +
             "; simulated points green inside the leaves of one of its octrees, red outside"});
  }
  return figures;
}

}  // namespace

std::string ToTable(const std::vector<SimulatedObject>& objects) {
  const auto rows = Rows(objects);
  std::vector<std::size_t> width;
  for (const auto& cell : Head()) width.push_back(cell.size());
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) width[i] = std::max(width[i], row[i].size());
  }
  std::string table;
  const auto append = [&](const std::vector<std::string>& row) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      table.append(row[i]).append(width[i] + 2 - row[i].size(), ' ');
    }
    table.erase(table.find_last_not_of(' ') + 1);
    table += '\n';
  };
  append(Head());
  for (const auto& row : rows) append(row);
  for (const SimulatedObject& object : objects) {
    table += NameOf(object) + ": deformed against unoccluded " + LossOf(object) + ", force " +
             Newtons(object.estimated_force) + " of " + Newtons(object.true_force) + "\n";
  }
  return table;
}

bool WriteSimulated(const std::vector<SimulatedObject>& objects, const DepthCamera& camera,
                    double leaf, const std::filesystem::path& folder) {
  Json json{{"leaf_m", leaf}, {"objects", Json::array()}};
  HtmlPage page("Shapes that fingertips tell, against the truth");
  page.Paragraph(
      "Octree score: share of what a virtual depth camera sees of the estimated shape that lies in "
      "the leaves of an octree around what it sees of the true one, both with its noise (paper B, "
      "figure 13), mean over eight lattices half a leaf apart, which move with the measured cloud. "
      "The estimate knows tactile samples and the fingertips' poses only.");
  page.Drawing(DrawScores(objects));
  page.Table(Head(), Rows(objects));
  for (const SimulatedObject& object : objects) {
    json["objects"].push_back(ToJson(object, leaf));
    page.Heading(NameOf(object));
    page.Paragraph("Deformed against unoccluded: " + LossOf(object) +
                   ". Force of the first "
                   "fingertip " +
                   Newtons(object.estimated_force) + ", in truth " + Newtons(object.true_force) +
                   ".");
    page.Figures(Figures(object, camera, leaf));
  }
  return WriteText(folder / "report.json", json.dump(2) + "\n") &&
         WriteText(folder / "report.html", page.Document());
}

}  // namespace palpate::study
