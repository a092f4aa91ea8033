// A measured cloud cut into objects.
#pragma once

#include <cstddef>
#include <vector>

#include "slave/study/clouds/point_cloud.h"

namespace palpate::study {

// Colour-based region growing (paper B, IV.C, after its reference 25), by the Point Cloud Library.
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

struct SegmentationOptions {
  enum class Method : std::uint8_t { kSurfaces, kColour } method = Method::kSurfaces;
  double voxel = 0;    // edge of a cell of the thinned-out cloud [m]; 0: 3 mm, or one and a half
                       // times the spacing of the points where that is more
  double plane = 0.3;  // extent from which a plane supports objects instead of being one [m]
  ColourGrowth colour;
  std::size_t smallest = 150;  // points of a region
};

struct Segmentation {
  std::vector<int> region_of;     // per point, from 0 for the largest region; -1: none
  std::vector<std::size_t> size;  // points of each region
  double voxel = 0;               // that was used [m]
  std::vector<bool> in_support;   // per point: it lies in a supporting plane; empty: not computed
};

// Frame of the cloud: the camera's, pupil at the origin, z forward. The same cloud gives the same
// answer. Without points: no regions.
//
// `kColour` is the paper's way: colour-based region growing over the whole cloud.
//
// `kSurfaces` tells objects apart that have many colours, or one colour with others:
// 1. The cloud is thinned out; strays and planes that support (table, floor, wall) are taken out.
// 2. Every voxel looks at its neighbours: where their centroid lies beside it, the surface ends
//    here; where it lies in front of it, two surfaces meet in a groove. Neither passes anything on.
// 3. What is left grows by colour into patches, and patches that touch are one surface, unless
//    their colours differ and they meet in a groove however shallow, or hardly: a printed tin stays
//    whole, a finger on foam does not join it.
// 4. What had passed nothing on joins the nearest region.
// Regions are surfaces in one piece: the inside of a bowl that is seen over its rim is another one
// than its outside, as are the two halves of what is seen left and right of a post.
Segmentation Segment(const PointCloud& cloud, const SegmentationOptions& options);

}  // namespace palpate::study
