// Round edges in a picture, whole or in part.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace palpate {

struct RoundEdge {
  Eigen::Vector2d centre{0, 0};  // [px]
  double radius = 0;             // [px]
};

// At most `count` circles that lie whole in `picture` (8 bit grey, smoothed), best first: those
// along which most of the gradient points outwards, or inwards, all round. Each direction counts at
// most once, however strong its edge. Every centre and radius (from 2 % of the longer edge on, in
// steps of 8 %) is tried at 160 px: about 20 ms.
std::vector<RoundEdge> FindRoundEdges(const cv::Mat& picture, std::size_t count);

}  // namespace palpate
