// Surface points from depth images: a grid of cells with fixed positions in the image.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// A plane over the image: a plane in space is linear in the slopes of the rays, 1/z = m . (x, y,
// 1).
using InverseDepth = Eigen::Vector3d;  // [1/m]

// A square of pixels, identified by its upper left pixel [px].
struct DepthCell {
  int column = 0, row = 0, edge = 0;
};

// The depths of the surface without contact, pixel by pixel.
class RestDepth {
 public:
  // Depths are counted in fractions of the image's unit.
  static constexpr int kFractions = 16;

  // Counts from `lowest` to `highest` are measurements. A pixel has no rest depth if its depths
  // differ by more than `flicker` counts, or if it is invalid in half of the images.
  RestDepth(int images, int lowest, int highest, double flicker);

  // Adds one image, CV_16U. False: it cannot be used (empty, another type or size than the first,
  // no measurement at all) and is not counted. Allocates at the first.
  bool Add(const cv::Mat& depth);
  [[nodiscard]] bool Fits(const cv::Mat& depth) const noexcept;
  [[nodiscard]] bool known() const { return taken_ >= images_; }
  void Reset() noexcept;

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  // Returns the depths of a row of pixels at rest, in fractions of a count; 0: unknown. Call after
  // known().
  [[nodiscard]] const std::int32_t* row(int v) const {
    return rest_.data() + static_cast<std::ptrdiff_t>(v) * width_;
  }
  [[nodiscard]] bool IsMeasured(std::uint16_t count) const {
    return count >= lowest_ && count <= highest_;
  }

  // The plane through the rest depths of a cell inside the image, without outliers; `unit` of a
  // count [m]. nullopt: fewer than `least` pixels, or all nearly on a line.
  struct Pinhole {
    double fx, fy, cx, cy;  // [px]
  };
  [[nodiscard]] std::optional<InverseDepth> PlaneOf(const DepthCell& cell, int least,
                                                    const Pinhole& camera, double unit) const;

 private:
  void Finish();

  int images_, lowest_, highest_;
  double flicker_;
  int width_ = 0, height_ = 0, taken_ = 0;
  std::vector<std::int32_t> rest_;  // while taken: sums of counts
  std::vector<std::uint16_t> seen_, min_count_, max_count_;
};

// The robust mean of how far depths changed within a cell.
class CellShift {
 public:
  struct Mean {
    double shift = 0;   // [counts], positive: away from the camera
    double spread = 0;  // standard deviation of those in the mean [counts]
    int count = 0;      // pixels that have a depth, now and at rest
  };
  // `edge` of the largest cell [px]; `sigma` of one depth [counts].
  CellShift(int edge, double sigma);

  // The mean of the changes within three sigma of their median, or three times their own spread if
  // that is wider. nullopt: fewer than `least` pixels. Allocation-free.
  [[nodiscard]] std::optional<Mean> Of(const cv::Mat& depth, const RestDepth& rest,
                                       const DepthCell& cell, int least) noexcept;

 private:
  double sigma_;                                // in fractions of a count
  std::vector<std::int32_t> changes_, sample_;  // in fractions of a count
};

// The displacement of the surface is the robust mean over a cell's pixels of present depth minus
// depth at rest, so that the slope across the cell cancels pixel by pixel. The cell's point at rest
// is the intersection of its central ray with the plane through its rest depths; it moves along
// that ray.
//
// A depth image does not identify material points, only the position of the surface: a point's
// covariance is that of its displacement along the normal, and a cell's width along the surface.
//
// Not thread-safe. Allocates while the baseline is measured.
class DepthPoints {
 public:
  struct Params {
    DepthImages camera;                // intrinsics, unit, pose, sigma of one depth
    int cell = 16;                     // edge of a cell [px]
    int rest_images = 5;               // the rest frame is their mean
    double min_full = 0.5;             // fraction of a cell's pixels that must have a depth
    double nearest = 0, farthest = 1;  // along the ray's z [m]: depths outside are not measurements
    // Edge of patches within which depth errors are equal [px]: a cell of n pixels has only n /
    // correlation^2 independent ones. 10 px was measured for a stereo depth camera at 0.1 m.
    double correlation = 10;
  };
  // Throws std::invalid_argument naming the parameter.
  explicit DepthPoints(const Params& params);

  // Processes one image: CV_16U, 0: no measurement. One point per cell with a rest depth; a cell's
  // identity is its position in the image, counted in rows. `found` is false while the rest shape
  // is measured (again after out of memory), for images that cannot be used (empty, another type or
  // size than the first), and if fewer than three points or a tenth of them are visible. Valid
  // until the next call.
  const SurfaceObservation& Observe(const cv::Mat& depth) noexcept;
  [[nodiscard]] bool at_rest_known() const { return rest_.known(); }
  // Measures the rest shape again from the next images, of any size.
  void Reset() noexcept;

  // Returns the position of point `i` of the observation: the centre of its cell [px], and the unit
  // normal of the surface at rest there, towards the camera, frame S.
  [[nodiscard]] const Eigen::Vector2d& place(std::size_t i) const { return cells_[i].middle; }
  [[nodiscard]] const Eigen::Vector3d& normal_S(std::size_t i) const { return cells_[i].n_S; }

 private:
  struct Cell {
    DepthCell square;
    Eigen::Vector2d middle{0, 0};    // [px]
    Eigen::Vector3d ray_S{0, 0, 1};  // vector along the central ray per metre of depth
    Eigen::Vector3d n_S{0, 0, -1};   // at rest, towards the camera
    Eigen::Matrix3d along_S =
        Eigen::Matrix3d::Zero();  // covariance along the surface, of the cell's width [m^2]
    double cosine = 0;            // displacement along the normal per change of depth [-]
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
