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
  double voxel = 0;               // edge of the voxels that were used [m]
};

// Divides a cloud into regions. The same cloud gives the same answer. The cloud is reduced to
// voxels of 3 mm, or of one and a half times the spacing of the points if that is more.
//
// `kColour` is the paper's method (paper B, IV.C, after its reference 25): colour-based region
// growing over the whole cloud. `kNone`: every point belongs to one region.
//
// `kSurfaces` separates objects that have many colours, or one colour with others:
//
// 1. Outliers and supporting planes (table, floor, wall) are removed.
// 2. Every voxel is compared with its neighbours: if their centroid is beside it, the surface ends
//    here; if it is in front of it, two surfaces meet in a groove. Regions grow across neither.
// 3. The remaining voxels grow by colour into patches. Adjacent patches are one surface, unless
//    their colours differ and they meet in a groove of any depth, or along a short border. So a
//    printed tin remains one region, and a finger on foam is separate.
// 4. The voxels of step 2 join the nearest region.
//
// Regions are connected surfaces: the inside of a bowl seen over its rim is another region than its
// outside, and so are two parts of an object on both sides of a post.
Segmentation Segment(const PointCloud::ConstPtr& cloud, Segmenting method);

}  // namespace palpate::study
