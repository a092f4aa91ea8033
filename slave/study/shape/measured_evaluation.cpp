#include "slave/study/shape/measured_evaluation.h"

#include <algorithm>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

namespace palpate::study {
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
  const double object = Span(question.rest_S.nodes), cloud = Span(question.measured.cloud.points);
  if (object >= kSmall) return;
  const bool far = question.measured.too_far > question.measured.cloud.size();
  if (!far && !(cloud > kWidest)) return;
  const std::string what =
      far ? fmt::format("most of its points are farther than {:g} m", kFarthestPoint)
          : fmt::format("it spans {:.3g} m", cloud);
  throw std::invalid_argument(
      fmt::format("{}: {}, the object {:.3g} m: units look wrong: accepted is a cloud in metres",
                  question.file, what, object));
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

}  // namespace palpate::study
