#include "slave/commands/evaluate/evaluate.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "shared/text/text.h"
#include "slave/commands/evaluate/estimated_shape.h"
#include "slave/commands/progress_bar.h"
#include "slave/scene/scene_loader.h"
#include "slave/study/shape/measured_evaluation.h"
#include "slave/study/shape/report_words.h"
#include "slave/study/shape/simulated_report.h"

namespace palpate {
namespace {

study::SegmentationOptions Segmenting(const EvaluateOptions& options) {
  study::SegmentationOptions segmentation;
  if (options.segment == "colour") {
    segmentation.method = study::SegmentationOptions::Method::kColour;
  } else if (options.segment != "surfaces" && options.segment != "no") {
    throw std::invalid_argument("--segment " + options.segment +
                                ": accepted is surfaces, colour or no");
  }
  constexpr int kMostNeighbours = 1000;
  if (options.neighbours < 1 || options.neighbours > kMostNeighbours) {
    throw std::invalid_argument("--neighbours " + std::to_string(options.neighbours) +
                                ": accepted is 1 to 1000");
  }
  for (const double threshold : {options.point_colour, options.region_colour}) {
    if (!(threshold >= 0 && threshold <= 442)) {
      throw std::invalid_argument("--point-colour, --region-colour " + std::to_string(threshold) +
                                  ": accepted is 0 to 442");
    }
  }
  if (!(options.voxel == 0 || (options.voxel >= 5e-4 && options.voxel <= 1))) {
    throw std::invalid_argument("--voxel " + std::to_string(options.voxel) +
                                ": accepted is 0, or 0.0005 to 1 m");
  }
  segmentation.voxel = options.voxel;
  segmentation.colour.neighbours = options.neighbours;
  segmentation.colour.point_colour = options.point_colour;
  segmentation.colour.region_colour = options.region_colour;
  return segmentation;
}

study::ObjectHint Hint(const EvaluateOptions& options) {
  study::ObjectHint hint;
  if (!options.at.empty()) {
    const Eigen::Vector3d at = Eigen::Map<const Eigen::VectorXd>(
        options.at.data(), static_cast<Eigen::Index>(options.at.size()));
    if (!at.allFinite()) throw std::invalid_argument("--at: accepted is x,y,z in metres");
    hint.at = at;
  }
  if (!options.colour.empty()) {
    std::array<std::uint8_t, 3> colour{};
    for (std::size_t i = 0; i < 3; ++i) {
      if (options.colour[i] < 0 || options.colour[i] > 255) {
        throw std::invalid_argument("--colour " + std::to_string(options.colour[i]) +
                                    ": accepted is red,green,blue from 0 to 255");
      }
      colour[i] = static_cast<std::uint8_t>(options.colour[i]);
    }
    hint.colour = colour;
  }
  return hint;
}

// Why there is no score where one was asked for; empty: there is one.
std::string NotScored(const study::MeasuredQuestion& question,
                      const study::MeasuredAnswer& answer) {
  if (answer.object.size() == 0) return answer.choice.why;
  if (!question.camera || std::isfinite(answer.score.octree)) return "";
  return "sense.depth_camera sees nothing of the estimated shape";
}

void Say(const study::MeasuredQuestion& question, const study::MeasuredAnswer& answer) {
  std::printf("object: %zu of %zu points, %s\n", answer.object.size(),
              question.measured.cloud.size(), answer.choice.why.c_str());
  for (const study::LabelScore& row : answer.labels) {
    std::printf("label %u: %zu points, %s%s\n", row.label, row.points,
                row.support ? "" : "intersection over union ", LabelWords(row).c_str());
  }
  if (!question.camera) {
    std::puts("not scored: the scene has no sense.depth_camera");
    return;
  }
  if (!std::isfinite(answer.score.octree)) return;
  std::printf("octree score: %s, %zu simulated points, leaves of %s\n",
              study::Percent(answer.score.octree).c_str(), answer.score.simulated,
              study::Millimetres(question.leaf).c_str());
  std::printf("measured points to the estimate: rms %s, 95 %% %s\n",
              study::Millimetres(answer.score.measured_to_surface.rms).c_str(),
              study::Millimetres(answer.score.measured_to_surface.p95).c_str());
}

void RequireOtherThanInputs(const EvaluateOptions& options, const Scene& scene) {
  std::vector<std::filesystem::path> inputs = InputFilesOf(scene);
  inputs.insert(inputs.end(), {options.cloud, options.contacts, options.loads});
  RequireOtherThan(
      "--out", options.out,
      {"report.json", "report.html", "object.pcd", "segmentation.pcd", "simulated.pcd"}, inputs);
}

int EvaluateCloud(const EvaluateOptions& options, const std::stop_token& stop) {
  study::MeasuredQuestion question;
  question.segmentation = Segmenting(options);
  question.segment = options.segment != "no";
  question.hint = Hint(options);
  question.leaf = options.leaf;
  question.measured = study::ReadPcd(options.cloud);
  question.file = options.cloud.filename().string();
  const Scene scene = LoadScene(options.scene, options.overrides, SceneUse::kSolve);
  RequireOtherThanInputs(options, scene);
  question.scene = scene.name;
  question.camera = scene.sense.depth_camera;
  {
    ProgressBar bar("evaluate", stop);
    const bool tables = !options.contacts.empty() || !options.loads.empty();
    EstimatedShape shape = tables ? ShapeUnderTables(scene, options.contacts, options.loads, &bar)
                                  : ShapeAfterRecording(scene, &bar);
    question.rest_S = std::move(shape.rest_S);
    question.estimate_S = std::move(shape.estimate_S);
    question.state = std::move(shape.state);
    question.fingers_S = std::move(shape.fingers_S);
  }
  const study::MeasuredAnswer answer = study::Evaluate(question);
  std::filesystem::create_directories(options.out);
  if (!study::WriteMeasured(question, answer, options.out)) {
    std::fprintf(stderr, "evaluate: %s cannot be written\n", options.out.c_str());
    return 1;
  }
  Say(question, answer);
  const std::string why = NotScored(question, answer);
  if (why.empty()) return 0;
  std::fprintf(stderr, "evaluate: %s: nothing was scored: %s\n", options.cloud.c_str(),
               why.c_str());
  return 1;
}

std::vector<study::SimulatedObject> Experiments(const EvaluateOptions& options, const Scene& scene,
                                                ProgressBar* bar) {
  std::vector<study::SimulatedObject> objects;
  study::ExperimentOptions experiment;
  experiment.repetitions = options.repetitions;
  experiment.leaf = options.leaf;
  const auto run = [&](const Scene& one, std::string_view material) {
    const std::string stage = material.empty() ? one.name : one.name + " " + std::string(material);
    experiment.progress = [&](double done) { return bar->Report(stage, done); };
    objects.push_back(study::RunExperiment(one, experiment));
    objects.back().material = material;
  };
  if (!options.materials) run(scene, "");
  for (const study::Foam& foam : study::kFoams) {
    if (options.materials) run(study::MadeOf(foam, scene), foam.name);
  }
  return objects;
}

int EvaluateSimulated(const EvaluateOptions& options, const std::stop_token& stop) {
  if (!options.contacts.empty() || !options.loads.empty() || !options.at.empty() ||
      !options.colour.empty()) {
    throw std::invalid_argument(
        "--contacts, --loads, --at, --colour: accepted is these with --cloud only");
  }
  const Scene scene = LoadScene(options.scene, options.overrides);
  RequireOtherThanInputs(options, scene);
  std::vector<study::SimulatedObject> objects;
  {
    ProgressBar bar("evaluate", stop);
    objects = Experiments(options, scene, &bar);
  }
  std::filesystem::create_directories(options.out);
  if (!study::WriteSimulated(objects, *scene.sense.depth_camera, options.leaf, options.out)) {
    std::fprintf(stderr, "evaluate: %s cannot be written\n", options.out.c_str());
    return 1;
  }
  std::fputs(study::ToTable(objects).c_str(), stdout);
  return 0;
}

}  // namespace

int RunEvaluate(const EvaluateOptions& options, const std::stop_token& stop) {
  if (!(options.leaf >= 1e-4 && options.leaf <= 1)) {
    throw std::invalid_argument("--leaf " + std::to_string(options.leaf) +
                                ": accepted is 0.0001 to 1 m");
  }
  return options.cloud.empty() ? EvaluateSimulated(options, stop) : EvaluateCloud(options, stop);
}

}  // namespace palpate
