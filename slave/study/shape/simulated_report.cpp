#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "shared/text/html_page.h"
#include "shared/text/svg.h"
#include "shared/text/text.h"
#include "slave/study/shape/cloud_picture.h"
#include "slave/study/shape/score_words.h"
#include "slave/study/shape/simulated_experiment.h"

namespace palpate::study {
namespace {

using Eigen::Vector2d;

constexpr double kLeft = 70, kTop = 46, kHeight = 260, kGroup = 130, kBelow = 64;
constexpr std::string_view kStyle = R"(
svg { font-family: system-ui, "DejaVu Sans", sans-serif; font-size: 12px; }
.paper { fill: #ffffff; } .ink { fill: #1d2430; } .soft { fill: #5b6576; }
.heading { font-size: 15px; font-weight: 600; }
.grid { stroke: #d9dee6; } .bar { stroke-width: 2; }
.s0 { fill: #2f6fd6; stroke: #2f6fd6; } .s1 { fill: #c98a00; stroke: #c98a00; }
.s2 { fill: #2f9e62; stroke: #2f9e62; }
.rest { fill: none; stroke: #d14545; stroke-width: 1.5; }
)";
constexpr std::array<std::string_view, 3> kClasses{"s0", "s1", "s2"};

// The lowest score, rounded down to the next tenth.
double Floor(const std::vector<SimulatedObject>& objects) {
  double low = 1;
  for (const auto& object : objects) {
    for (const auto& state : object.states) {
      for (const auto& score : state.scores) low = std::min(low, score.octree);
    }
  }
  return std::clamp(std::floor(10 * low) / 10, 0.0, 0.9);
}

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

std::vector<HtmlPage::Figure> Figures(const SimulatedObject& object, const DepthCamera& camera,
                                      double leaf) {
  std::vector<HtmlPage::Figure> figures;
  // One view for all states, so that they can be compared.
  const PictureView aside = ViewOf(camera.X_SD, object.states[0].estimate_S.nodes, kTurn);
  for (const ShapeState& state : object.states) {
    figures.push_back({PictureOfShapes(aside, state.measured_S, state.estimate_S, state.fingers_S),
                       NameOf(object) + ", " + state.name +
                           ": measured points (near ones dark) and the mesh of the estimate"});
    figures.push_back(
        {PictureOfLeaves(aside, state.measured_S, state.simulated_S, leaf),
         NameOf(object) + ", " + state.name + ": octree score " +
             Percent(state.scores.back().octree) +
             "; simulated points are green inside the leaves of one of its octrees, red outside"});
  }
  return figures;
}

}  // namespace

std::string DrawScores(const std::vector<SimulatedObject>& objects) {
  const double width =
      kLeft + kGroup * static_cast<double>(std::max<std::size_t>(objects.size(), 4)) + 20;
  Svg svg(width, kTop + kHeight + kBelow, "Octree scores", kStyle);
  svg.Rectangle({0, 0}, {width, kTop + kHeight + kBelow}, "paper");
  svg.Text({kLeft, 22}, "Octree score by state", "ink heading");
  const double low = Floor(objects);
  const auto y = [&](double share) { return kTop + kHeight * (1 - (share - low) / (1 - low)); };
  for (int i = 0; i <= 5; ++i) {
    const double share = low + (1 - low) * i / 5;
    svg.Line({kLeft, y(share)}, {width - 20, y(share)}, "grid");
    svg.Text({kLeft - 8, y(share) + 4}, Percent(share), "soft", Svg::Anchor::kEnd);
  }
  for (std::size_t k = 0; k < objects.size(); ++k) {
    const double x = kLeft + kGroup * (static_cast<double>(k) + 0.5);
    svg.Text({x, kTop + kHeight + 20}, objects[k].name, "ink", Svg::Anchor::kMiddle);
    svg.Text({x, kTop + kHeight + 36}, objects[k].material, "soft", Svg::Anchor::kMiddle);
    for (std::size_t s = 0; s < 3; ++s) {
      const ShapeState& state = objects[k].states[s];
      const auto [least, most] = RangeOf(state);
      const double at = x + 28 * (static_cast<double>(s) - 1);
      const std::string style(kClasses[s]);
      svg.Line({at, y(least)}, {at, y(most)}, "bar " + style);
      svg.Circle({at, y(state.mean_octree())}, 5, style,
                 state.name + " " + Percent(state.mean_octree()));
    }
    const double rest = std::max(low, objects[k].states[2].mean_undeformed());
    svg.Circle({x + 28, y(rest)}, 5, "rest", "rest shape " + Percent(rest));
  }
  for (std::size_t s = 0; s < 3 && !objects.empty(); ++s) {
    const Vector2d at(kLeft + 6 + 110 * static_cast<double>(s), kTop + kHeight + 54);
    svg.Circle(at, 5, kClasses[s]);
    svg.Text(at + Vector2d(10, 4), objects[0].states[s].name, "ink");
  }
  const Vector2d at(kLeft + 336, kTop + kHeight + 54);
  svg.Circle(at, 5, "rest");
  svg.Text(at + Vector2d(10, 4), "deformed, compared with the rest shape", "ink");
  return svg.Document();
}

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

bool WriteSimulated(const std::vector<SimulatedObject>& objects, const DepthCamera& camera,
                    double leaf, const std::filesystem::path& folder) {
  Json json{{"leaf_m", leaf}, {"objects", Json::array()}};
  HtmlPage page("Shapes estimated from fingertips, compared with the true shape");
  page.Paragraph(
      "Octree score: share of the estimated shape's points that lie in the leaves of an octree "
      "around the true shape's points (paper B, figure 13). A virtual depth camera with noise "
      "measures both. The score is the mean over eight lattices half a leaf apart, aligned with "
      "the measured cloud. The estimate uses only tactile samples and the poses of the "
      "fingertips.");
  page.Drawing(DrawScores(objects));
  page.Table(Head(), Rows(objects));
  for (const SimulatedObject& object : objects) {
    json["objects"].push_back(ToJson(object, leaf));
    page.Heading(NameOf(object));
    page.Paragraph("Deformed against unoccluded: " + LossOf(object) +
                   ". Force of the first "
                   "fingertip " +
                   Newtons(object.estimated_force) + ", true " + Newtons(object.true_force) + ".");
    page.Figures(Figures(object, camera, leaf));
  }
  return TryWrite(folder / "report.json", json.dump(2) + "\n") &&
         TryWrite(folder / "report.html", page.Document());
}

}  // namespace palpate::study
