// How well a segmentation agrees with a cloud whose points are labelled.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "slave/study/clouds/point_cloud.h"
#include "slave/study/clouds/segmentation.h"

namespace palpate::study {

struct LabelScore {
  std::uint32_t label = 0;
  std::size_t points = 0;
  int region = -1;       // that shares most with it; -1: none does
  double iou = 0;        // intersection over union with that region [-]
  bool support = false;  // more than half of it lies in supporting planes: no object, not scored
};

// One row per label, ascending. Empty: the cloud has no labels.
std::vector<LabelScore> ScoreLabels(const PointCloud& cloud, const Segmentation& segmentation);

}  // namespace palpate::study
