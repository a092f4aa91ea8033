#include "slave/study/shape/measured_evaluation.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <stdexcept>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "shared/text/text.h"
#include "slave/study/shape/score_words.h"

namespace palpate::study {
namespace {

// Another seed than any other picture of the scene has.
constexpr std::uint32_t kSeed = 1;
// How far an object may have been moved or bulged from where the scene has it [m].
constexpr double kMargin = 0.02;

ObjectHint WithBox(const MeasuredQuestion& question) {
  ObjectHint hint = question.hint;
  for (const SurfaceMesh* surface : {&question.shape.rest_S, &question.shape.estimate_S}) {
    for (const auto& p : surface->nodes) {
      if (p.allFinite()) hint.box.extend(p);
    }
  }
  hint.box.min().array() -= kMargin;
  hint.box.max().array() += kMargin;
  if (question.camera) hint.X_BD = question.camera->X_SD;
  return hint;
}

Segmentation Everything(std::size_t points) {
  return {std::vector<int>(points, 0), {points}, 0, {}};
}

// What the middle 90 % of the points span along the axis in which they span most [m].
double Span(const std::vector<Eigen::Vector3d>& points) {
  double widest = 0;
  std::vector<double> values(points.size());
  for (Eigen::Index axis = 0; axis < 3 && !points.empty(); ++axis) {
    std::ranges::transform(points, values.begin(), [&](const auto& p) { return p[axis]; });
    std::ranges::sort(values);
    const std::size_t cut = values.size() / 20;
    widest = std::max(widest, values[values.size() - 1 - cut] - values[cut]);
  }
  return widest;
}

// Cameras that write millimetres are common.
void RequireMetres(const MeasuredQuestion& question) {
  constexpr double kWidest = 20, kSmall = 1;  // [m]
  const double object = Span(question.shape.rest_S.nodes),
               cloud = Span(question.measured.cloud.points);
  if (object >= kSmall) return;
  const bool far = question.measured.too_far > question.measured.cloud.size();
  if (!far && !(cloud > kWidest)) return;
  const std::string what =
      far ? fmt::format("most of its points are farther than {:g} m", kFarthestPoint)
          : fmt::format("it spans {:.3g} m", cloud);
  throw std::invalid_argument(fmt::format(
      "{}: {}, the object {:.3g} m: the units look wrong: accepted is a cloud in metres",
      question.file, what, object));
}

using Json = nlohmann::ordered_json;

Json Regions(const MeasuredAnswer& answer) {
  Json regions = Json::array();
  for (std::size_t k = 0; k < answer.segmentation.size.size(); ++k) {
    regions.push_back({{"region", k}, {"points", answer.segmentation.size[k]}});
  }
  return regions;
}

Json Labels(const MeasuredAnswer& answer) {
  Json labels = Json::array();
  for (const LabelScore& row : answer.labels) {
    labels.push_back({{"label", row.label},
                      {"points", row.points},
                      {"support", row.support},
                      {"region", row.region},
                      {"iou", row.support ? Json(nullptr) : Json(row.iou)}});
  }
  return labels;
}

Json ToJson(const MeasuredQuestion& question, const MeasuredAnswer& answer) {
  const bool by_colour = question.segmentation.method == SegmentationOptions::Method::kColour;
  Json json{{"scene", question.scene},
            {"cloud",
             {{"file", question.file},
              {"points", question.measured.cloud.size()},
              {"dropped", question.measured.dropped}}},
            {"segmentation",
             {{"method", !question.segment ? "no"
                         : by_colour       ? "colour"
                                           : "surfaces"},
              {"voxel_m", answer.segmentation.voxel},
              {"regions", Regions(answer)},
              {"labels", Labels(answer)}}},
            {"object",
             {{"regions", answer.choice.regions},
              {"why", answer.choice.why},
              {"sure", answer.choice.sure},
              {"points", answer.object.size()}}},
            {"state", question.shape.state},
            {"score", nullptr}};
  if (question.camera) json["score"] = ScoreJson(answer.score, question.leaf);
  return json;
}

using Rgb = std::array<std::uint8_t, 3>;

// Colours that are distinguishable on white, used cyclically.
Rgb RegionColour(int region) {
  constexpr std::array<Rgb, 8> kColours{{{47, 111, 214},
                                         {47, 158, 98},
                                         {201, 138, 0},
                                         {209, 69, 69},
                                         {130, 80, 190},
                                         {20, 150, 170},
                                         {150, 110, 70},
                                         {220, 110, 170}}};
  return kColours[static_cast<std::size_t>(region) % kColours.size()];
}

PointCloud InRegions(const MeasuredQuestion& question, const MeasuredAnswer& answer) {
  PointCloud cloud{question.measured.cloud.points, {}, {}};
  for (const int region : answer.segmentation.region_of) {
    cloud.labels.push_back(static_cast<std::uint32_t>(region + 1));
    cloud.colours.push_back(region < 0 ? Rgb{205, 210, 218} : RegionColour(region));
  }
  return cloud;
}

}  // namespace

MeasuredAnswer Evaluate(const MeasuredQuestion& question) {
  const PointCloud& cloud = question.measured.cloud;
  MeasuredAnswer answer;
  RequireMetres(question);
  if (cloud.size() < 2) {
    answer.choice = {
        {}, cloud.size() == 0 ? "the cloud has no point" : "the cloud has a single point", false};
    answer.segmentation.region_of.assign(cloud.size(), -1);
    return answer;
  }
  if (question.segment) {
    answer.segmentation = Segment(cloud, question.segmentation);
    answer.choice = ChooseObject(cloud, answer.segmentation, WithBox(question));
  } else {
    answer.segmentation = Everything(cloud.size());
    answer.choice = {{0}, "every point belongs to the object, as requested"};
  }
  answer.labels = ScoreLabels(cloud, answer.segmentation);
  answer.object = Chosen(cloud, answer.segmentation, answer.choice.regions);
  if (!question.camera) return answer;
  for (const auto& p : answer.object.points) {
    answer.measured_S.emplace_back(question.camera->X_SD * p);
  }
  answer.simulated_S =
      ScanSurface(*question.camera, question.shape.estimate_S, question.shape.fingers_S, kSeed);
  answer.score =
      Score(answer.measured_S, answer.simulated_S, question.shape.estimate_S, question.leaf);
  return answer;
}

bool WriteMeasured(const MeasuredQuestion& question, const MeasuredAnswer& answer,
                   const std::filesystem::path& folder) {
  bool written = TryWrite(folder / "report.json", ToJson(question, answer).dump(2) + "\n") &&
                 WritePcd(folder / "object.pcd", answer.object) &&
                 WritePcd(folder / "segmentation.pcd", InRegions(question, answer));
  if (question.camera) {
    PointCloud simulated;
    const Eigen::Isometry3d X_DS = question.camera->X_SD.inverse();
    for (const auto& p : answer.simulated_S) simulated.points.emplace_back(X_DS * p);
    written = written && WritePcd(folder / "simulated.pcd", simulated);
  }
  return written;
}

}  // namespace palpate::study
