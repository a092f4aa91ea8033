#include "slave/study/clouds/label_score.h"

#include <map>
#include <utility>

namespace palpate::study {

std::vector<LabelScore> ScoreLabels(const PointCloud& cloud, const Segmentation& segmentation) {
  std::map<std::uint32_t, std::size_t> points, support;
  std::map<std::pair<std::uint32_t, int>, std::size_t> shared;
  for (std::size_t i = 0; i < cloud.labels.size(); ++i) {
    ++points[cloud.labels[i]];
    if (!segmentation.in_support.empty() && segmentation.in_support[i]) ++support[cloud.labels[i]];
    if (segmentation.region_of[i] >= 0) ++shared[{cloud.labels[i], segmentation.region_of[i]}];
  }
  std::map<std::uint32_t, LabelScore> scores;
  for (const auto& [label, count] : points)
    scores[label] = {label, count, -1, 0, 2 * support[label] > count};
  for (const auto& [pair, both] : shared) {
    LabelScore& score = scores[pair.first];
    if (score.support) continue;
    const std::size_t all =
        score.points + segmentation.size[static_cast<std::size_t>(pair.second)] - both;
    const double iou = static_cast<double>(both) / static_cast<double>(all);
    if (iou > score.iou) score.iou = iou, score.region = pair.second;
  }
  std::vector<LabelScore> rows;
  for (const auto& [label, score] : scores) rows.push_back(score);
  return rows;
}

}  // namespace palpate::study
