// A measured cloud cut into objects.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "slave/study/clouds/point_cloud.h"

namespace palpate::study {

enum class Segmenting : std::uint8_t { kSurfaces, kColour, kNone };

struct Segmentation {
  std::vector<int> region_of;     // per point, from 0 for the largest region; -1: none
  std::vector<std::size_t> size;  // points of each region, at least 150
  double voxel = 0;               // that was used [m]
};

// Divides a cloud into regions. The same cloud gives the same answer. The cloud is thinned out to
// voxels of 3 mm, or one and a half times the spacing of the points where that is more.
//
// `kColour` is the paper's way (paper B, IV.C, after its reference 25): colour-based region growing
// over the whole cloud. `kNone`: every point belongs to one region.
//
// `kSurfaces` separates objects that have many colours, or one colour with others:
// 1. Strays and planes that support (table, floor, wall) are taken out.
// 2. Every voxel is compared with its neighbours: where their centroid lies beside it, the surface
//    ends here; where it lies in front of it, two surfaces meet in a groove. Regions do not grow
//    over either.
// 3. What is left grows by colour into patches, and patches that touch are one surface, unless
//    their colours differ and they meet in a groove however shallow, or hardly: a printed tin stays
//    whole, a finger on foam does not join it.
// 4. The voxels of step 2 join the nearest region.
// Regions are surfaces in one piece: the inside of a bowl that is seen over its rim is another one
// than its outside, as are the two halves of what is seen left and right of a post.
Segmentation Segment(const PointCloud::ConstPtr& cloud, Segmenting method);

}  // namespace palpate::study
