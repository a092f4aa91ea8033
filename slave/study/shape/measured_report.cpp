#include <cmath>
#include <cstdio>
#include <fstream>

#include <nlohmann/json.hpp>

#include "slave/study/shape/html_page.h"
#include "slave/study/shape/measured_evaluation.h"
#include "slave/study/shape/report_words.h"
#include "slave/study/shape/shape_pictures.h"

namespace palpate::study {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kTurn = 0.5;  // by which one looks past the leaves [rad]

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
            {"state", question.state},
            {"score", nullptr}};
  if (question.camera) json["score"] = ScoreJson(answer.score, question.leaf);
  return json;
}

// The pictures are taken from the camera; the cloud is in its frame.
std::vector<HtmlPage::Figure> Figures(const MeasuredQuestion& question,
                                      const MeasuredAnswer& answer) {
  const PointCloud& cloud = question.measured.cloud;
  const auto here = Eigen::Isometry3d::Identity();
  const PictureView wide = ViewOf(here, cloud.points);
  std::vector<HtmlPage::Figure> figures{
      {PictureOfCloud(wide, cloud), "What the camera measured"},
      {PictureOfRegions(wide, cloud, answer.segmentation),
       "Its regions, the largest blue; grey: support and rest"},
      {PictureOfCloud(ViewOf(here, answer.object.points), answer.object), "The object's points"}};
  if (!question.camera || answer.simulated_S.empty()) return figures;
  const Eigen::Isometry3d& X_SD = question.camera->X_SD;
  std::vector<Eigen::Vector3d> both = answer.measured_S;
  both.insert(both.end(), answer.simulated_S.begin(), answer.simulated_S.end());
  const PictureView aside = ViewOf(X_SD, both, kTurn);
  figures.push_back(
      {PictureOfShapes(aside, answer.measured_S, question.estimate_S, question.fingers_S),
       "The object's points, near ones dark, and the estimate's mesh"});
  figures.push_back(
      {PictureOfLeaves(aside, answer.measured_S, answer.simulated_S, question.leaf),
       "One of the eight octrees of the measured points; simulated points green inside "
       "its leaves, red outside"});
  return figures;
}

std::string ToHtml(const MeasuredQuestion& question, const MeasuredAnswer& answer) {
  HtmlPage page("Shape of " + question.scene + " against " + question.file);
  if (question.camera) {
    page.Paragraph("Octree score " + Percent(answer.score.octree) + " at leaves of " +
                   Millimetres(question.leaf) + ", mean over eight lattices half a leaf apart" +
                   "; the estimate is " + question.state + ".");
    page.Table(DistanceHead("distance"),
               {DistanceRow("measured points to the estimate", answer.score.measured_to_surface),
                DistanceRow("simulated points to measured", answer.score.simulated_to_measured)});
  } else {
    page.Paragraph("Only segmented: the scene has no sense.depth_camera.");
  }
  page.Paragraph("The object: " + answer.choice.why + ", " + std::to_string(answer.object.size()) +
                 " points.");
  page.Figures(Figures(question, answer));
  if (!answer.labels.empty()) {
    page.Heading("Labels of the cloud");
    std::vector<std::vector<std::string>> rows;
    for (const LabelScore& row : answer.labels) {
      rows.push_back({std::to_string(row.label), std::to_string(row.points),
                      row.region < 0 ? "none" : std::to_string(row.region), LabelWords(row)});
    }
    page.Table({"label", "points", "region", "intersection over union"}, rows);
  }
  return page.Document();
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

bool WriteMeasured(const MeasuredQuestion& question, const MeasuredAnswer& answer,
                   const std::filesystem::path& folder) {
  bool written = WriteText(folder / "report.json", ToJson(question, answer).dump(2) + "\n") &&
                 WriteText(folder / "report.html", ToHtml(question, answer)) &&
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
