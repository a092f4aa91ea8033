// Result of tracking in one image, and the mapping of its pixels to S.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slave/scene/scene.h"

namespace palpate {

struct TipObservation {
  bool found = false;
  Eigen::Vector2d p_I{0, 0};  // tip [px], sub-pixel
  double score = 0;           // normalised cross-correlation at the peak [-1, 1]
  double sigma = 0;           // one standard deviation of p_I per axis [px]
  bool reacquired = false;    // found by a search of the whole image
  double covered = 0;         // hidden share of the template [0, 1]
  bool aligned = false;       // the template's fine alignment agrees with the peak
  double turn = 0;            // of the tool since the template, from x towards y of the image [rad]
  // Vector from the aligned part of the tip to the tip [px]; it grows with the scale of the image.
  Eigen::Vector2d lever{0, 0};
};

// Mapping of the image plane I to the plane z = 0 of S: one pixel size, one pose, no perspective
// (paper A: a camera that looks straight at a planar scene, or a microscope). A tool behind the
// front of a thick body has a separate view.
class CameraView {
 public:
  // `width`, `height` of the image [px]. The scene's pixel size > 0.
  CameraView(const Camera& camera, int width, int height)
      : X_SC_(camera.X_SC), pixel_(camera.pixel), centre_(0.5 * (width - 1), 0.5 * (height - 1)) {}

  // `p_I` [px], x right, y down, (0, 0) at the centre of the upper left pixel -> S [m].
  [[nodiscard]] Eigen::Vector3d ToSlave(const Eigen::Vector2d& p_I) const {
    const Eigen::Vector2d d = pixel_ * (p_I - centre_);
    return X_SC_ * Eigen::Vector3d(d.x(), -d.y(), 0);
  }
  // S [m] -> image [px].
  [[nodiscard]] Eigen::Vector2d ToImage(const Eigen::Vector3d& p_S) const {
    const Eigen::Vector3d p_C = X_SC_.inverse() * p_S;
    return centre_ + Eigen::Vector2d(p_C.x(), -p_C.y()) / pixel_;
  }
  // Mapping to the plane `depth` [m] behind z = 0, for a projection centre `distance` [m] before
  // it: there a pixel is larger. The camera looks along z. 0: the rays are parallel.
  [[nodiscard]] CameraView Behind(double depth, double distance) const {
    CameraView behind = *this;
    if (distance > 0) behind.pixel_ *= 1 + depth / distance;
    return behind;
  }
  [[nodiscard]] double pixel() const { return pixel_; }  // [m/px]

 private:
  Eigen::Isometry3d X_SC_;
  double pixel_;
  Eigen::Vector2d centre_;
};

}  // namespace palpate
