// Depth pictures as points of the surface: a grid of cells that keep their places in the picture.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/vision/depth/cell_shift.h"
#include "slave/vision/depth/rest_depth.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// How far the surface moved is the robust mean, over a cell's pixels, of depth now minus depth at
// rest: the slope of the surface across the cell cancels pixel by pixel. The cell's point at rest
// is where its middle ray meets the plane through its rest depths; it moves along that ray.
//
// A depth picture does not tell which piece of the surface it sees, only where the surface is: a
// point's covariance is that of its way from rest along the normal, and a cell's width along the
// surface.
//
// Not thread-safe. Allocates while the rest frame is taken.
class DepthPoints {
 public:
  struct Params {
    DepthPictures camera;              // intrinsics, unit, pose, sigma of one depth
    int cell = 16;                     // edge of a cell [px]
    int rest_pictures = 5;             // the rest frame is their mean
    double least_full = 0.5;           // share of a cell's pixels that must have a depth
    double nearest = 0, farthest = 1;  // along the ray's z [m]: what lies outside is no measurement
    // Depths err alike within patches of this edge [px]: a cell of n pixels has only
    // n / correlation^2 independent ones. 10 px: a stereo depth camera at 0.1 m, measured.
    double correlation = 10;
  };
  // Throws std::invalid_argument naming the parameter.
  explicit DepthPoints(const Params& params);

  // One picture: CV_16U, 0: no measurement. One point per cell that had a depth at rest; a cell's
  // identity is its place in the picture, counted in rows. `found` is false while the rest frame is
  // taken (anew where memory runs out), for pictures that cannot be used (empty, another type or
  // size than the first), and where fewer than three points or a tenth of them are seen. Valid
  // until the next call.
  const SurfaceObservation& Observe(const cv::Mat& depth, std::uint64_t sequence,
                                    Time sensed_at) noexcept;
  [[nodiscard]] bool at_rest_known() const { return rest_.known(); }
  // The rest frame is taken anew from the next pictures, of any size.
  void Reset() noexcept;

  // Of point `i` of the observation: the middle of its cell [px], and the unit normal of the
  // surface at rest there, towards the camera, frame S.
  [[nodiscard]] const Eigen::Vector2d& place(std::size_t i) const { return cells_[i].middle; }
  [[nodiscard]] const Eigen::Vector3d& normal_S(std::size_t i) const { return cells_[i].n_S; }

 private:
  struct Cell {
    DepthCell square;
    Eigen::Vector2d middle{0, 0};    // [px]
    Eigen::Vector3d ray_S{0, 0, 1};  // a metre of depth along the middle ray
    Eigen::Vector3d n_S{0, 0, -1};   // at rest, towards the camera
    Eigen::Matrix3d along_S =
        Eigen::Matrix3d::Zero();  // covariance along the surface, of the cell's width [m^2]
    double cosine = 0;            // of depth to the way along the normal [-]
  };
  void MakeCells();
  void Measure(const cv::Mat& depth, const Cell& cell, SurfacePoint* point) noexcept;

  Params params_;
  RestDepth rest_;
  CellShift shift_;
  std::vector<Cell> cells_;
  SurfaceObservation observation_;
};

}  // namespace palpate
