// Colour-based region growing (paper B, IV.C, after its reference 25), by the Point Cloud Library.
#pragma once

#include <vector>

#include "slave/study/clouds/point_cloud.h"

namespace palpate::study {

struct ColourGrowth {
  int neighbours = 30;        // of a point, into which its region may grow
  double point_colour = 20;   // largest difference between neighbours of a region [0 to 442]
  double region_colour = 10;  // neighbouring regions less different than this are united
  double distance = 0.01;     // between regions that are neighbours [m]
  int smallest = 30;          // points of a region; smaller ones join a neighbour, or none
};

// Which region every point belongs to, counted from 0; -1: none. Without colours: one region.
// O(N log N).
std::vector<int> GrowColours(const PointCloud& cloud, const ColourGrowth& options);

}  // namespace palpate::study
