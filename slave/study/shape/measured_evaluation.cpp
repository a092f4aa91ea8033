#include "slave/study/shape/measured_evaluation.h"

#include <array>
#include <cstdint>

#include <nlohmann/json.hpp>
#include <pcl/common/colors.h>

#include "shared/text/text.h"
#include "slave/study/shape/score_text.h"

namespace palpate::study {
namespace {

// Seed that no other image of the scene uses.
constexpr std::uint32_t kSeed = 1;
// Largest displacement of the object from its position in the scene, including bulging [m].
constexpr double kMargin = 0.02;

ObjectHint WithBox(const MeasuredQuestion& question) {
  ObjectHint hint = question.hint;
  for (const SurfaceMesh* surface : {&question.shape.rest_S, &question.shape.estimate_S}) {
    for (const auto& p : surface->nodes) hint.box.extend(p);
  }
  hint.box.min().array() -= kMargin;
  hint.box.max().array() += kMargin;
  if (question.camera) hint.X_BD = question.camera->X_SD;
  return hint;
}

using Json = nlohmann::ordered_json;

Json Regions(const MeasuredAnswer& answer) {
  Json regions = Json::array();
  for (std::size_t k = 0; k < answer.segmentation.size.size(); ++k) {
    regions.push_back({{"region", k}, {"points", answer.segmentation.size[k]}});
  }
  return regions;
}

Json ToJson(const MeasuredQuestion& question, const MeasuredAnswer& answer) {
  static constexpr std::array kMethods{"surfaces", "colour", "no"};  // in the order of Segmenting
  Json json{{"scene", question.scene},
            {"cloud",
             {{"file", question.file},
              {"points", question.measured.cloud->size()},
              {"dropped", question.measured.dropped}}},
            {"segmentation",
             {{"method", kMethods[static_cast<std::size_t>(question.segmenting)]},
              {"voxel_m", answer.segmentation.voxel},
              {"regions", Regions(answer)}}},
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

PointCloud InRegions(PointCloud cloud, const std::vector<int>& region_of) {
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto label = static_cast<std::uint32_t>(region_of[i] + 1);
    const pcl::RGB colour = pcl::GlasbeyLUT::at(label % pcl::GlasbeyLUT::size());
    cloud[i].label = label;
    cloud[i].rgba = colour.rgba;
  }
  return cloud;
}

}  // namespace

MeasuredAnswer Evaluate(const MeasuredQuestion& question) {
  const PointCloud::ConstPtr cloud = question.measured.cloud;
  MeasuredAnswer answer;
  answer.segmentation = Segment(cloud, question.segmenting);
  answer.choice = question.segmenting == Segmenting::kNone
                      ? ObjectChoice{{0}, "every point belongs to the object, as requested"}
                      : ChooseObject(*cloud, answer.segmentation, WithBox(question));
  answer.object = Chosen(*cloud, answer.segmentation, answer.choice.regions);
  if (!question.camera) return answer;
  const Eigen::Isometry3d& X_SD = question.camera->X_SD;
  std::vector<Eigen::Vector3d> measured_S;
  for (const auto& p : answer.object) {
    measured_S.emplace_back(X_SD * p.getVector3fMap().cast<double>());
  }
  const std::vector<Eigen::Vector3d> simulated_S =
      ScanSurface(*question.camera, question.shape.estimate_S, question.shape.fingers_S, kSeed);
  for (const auto& p : simulated_S) {
    answer.simulated.emplace_back().getVector3fMap() = (X_SD.inverse() * p).cast<float>();
  }
  answer.score = Score(measured_S, simulated_S, question.shape.estimate_S, question.leaf);
  return answer;
}

bool WriteMeasured(const MeasuredQuestion& question, const MeasuredAnswer& answer,
                   const std::filesystem::path& folder) {
  const PointCloud regions = InRegions(*question.measured.cloud, answer.segmentation.region_of);
  return TryWrite(folder / "report.json", ToJson(question, answer).dump(2) + "\n") &&
         WritePcd(folder / "object.pcd", answer.object) &&
         WritePcd(folder / "segmentation.pcd", regions) &&
         WritePcd(folder / "simulated.pcd", answer.simulated);
}

}  // namespace palpate::study
