#include "slave/study/shape/measured_evaluation.h"

namespace palpate {
namespace {

// Another seed than any other picture of the scene has.
constexpr std::uint32_t kSeed = 1;
// How far an object may have been moved or bulged from where the scene has it [m].
constexpr double kMargin = 0.02;

ObjectHint WithBox(const MeasuredQuestion& question) {
  ObjectHint hint = question.hint;
  for (const SurfaceMesh* surface : {&question.rest_S, &question.estimate_S}) {
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
  return {std::vector<int>(points, 0), {points}, 0};
}

}  // namespace

MeasuredAnswer Evaluate(const MeasuredQuestion& question) {
  const PointCloud& cloud = question.measured.cloud;
  MeasuredAnswer answer;
  if (cloud.size() == 0) {
    answer.choice = {{}, "the cloud has no point", false};
    return answer;
  }
  if (question.segment) {
    answer.segmentation = Segment(cloud, question.segmentation);
    answer.choice = ChooseObject(cloud, answer.segmentation, WithBox(question));
  } else {
    answer.segmentation = Everything(cloud.size());
    answer.choice = {{0}, "every point is said to be the object's"};
  }
  answer.labels = ScoreLabels(cloud, answer.segmentation);
  answer.object = Chosen(cloud, answer.segmentation, answer.choice.regions);
  if (!question.camera) return answer;
  for (const auto& p : answer.object.points) {
    answer.measured_S.emplace_back(question.camera->X_SD * p);
  }
  answer.simulated_S = SeeSurface(*question.camera, question.estimate_S, question.fingers_S, kSeed);
  answer.score = Score(answer.measured_S, answer.simulated_S, question.estimate_S, question.leaf);
  return answer;
}

}  // namespace palpate
