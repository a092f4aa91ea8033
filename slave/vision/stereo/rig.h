// A camera's lens, a stereo pair, and triangulation of points (paper C, 3.1).
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace palpate {

// Pinhole with OpenCV's distortion model. Pixels: (0, 0) is the centre of the upper left one.
struct Lens {
  double fx = 0, fy = 0, cx = 0, cy = 0;  // [px]
  std::array<double, 5> distortion{};     // k1 k2 p1 p2 k3 [-]
  std::array<int, 2> size{0, 0};          // [px] width, height
};

// Camera frames L, R: z forward, x right, y down.
struct StereoRig {
  Lens left, right;
  Eigen::Isometry3d X_RL = Eigen::Isometry3d::Identity();  // p_R = X_RL p_L [m]
  double rms_px = 0;  // reprojection residual over all images of the calibration; 0: unknown
  [[nodiscard]] double baseline() const { return X_RL.translation().stableNorm(); }
};

// YAML files in the manner of OpenCV's FileStorage, documented in the .cpp; `right` is absent in
// the file of one camera. Throws std::runtime_error `file: ...`: unreadable, a key missing (which),
// numbers that make no lens.
StereoRig ReadRig(const std::filesystem::path& file);
// The text of such a file; without a baseline that of the left camera alone.
std::string RigText(const StereoRig& rig);
void WriteRig(const std::filesystem::path& file, const StereoRig& rig);

// Image -> ray: (x/z, y/z) in the camera's frame, without distortion. nullopt: outside the lens's
// invertible range, or not finite.
std::optional<Eigen::Vector2d> RayOf(const Lens& lens, const Eigen::Vector2d& p_I) noexcept;
// Camera frame [m] -> image [px], with distortion. nullopt: behind the camera, or so far off axis
// that the distortion folds back and another ray has that pixel.
std::optional<Eigen::Vector2d> Project(const Lens& lens, const Eigen::Vector3d& p_C) noexcept;

struct Triangulated {
  Eigen::Vector3d p_L{0, 0, 0};                          // [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // [m^2]
  // Distance of the two rays in pixels of the left image; > 0: the left ray lies towards
  // AcrossEpipolar.
  double miss_px = 0;
};
// Returns the point whose projections are nearest to both, with its covariance for `sigma_px` per
// axis. nullopt: rays that do not meet in front of both cameras, parallel rays, not finite.
std::optional<Triangulated> Triangulate(const StereoRig& rig, const Eigen::Vector2d& left_I,
                                        const Eigen::Vector2d& right_I, double sigma_px) noexcept;

// Returns the unit direction in the undistorted left image across the epipolar line through
// `left_I`, with the same sense for all points: downwards if the right camera is to the right.
Eigen::Vector2d AcrossEpipolar(const StereoRig& rig, const Eigen::Vector2d& left_I) noexcept;

// The distortion of a Lens and its derivative, for inversion and fitting. OpenCV's model: with r^2
// = x^2 + y^2, x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), y' = y (...) +
// p1 (r^2 + 2 y^2) + 2 p2 x y; `ray` = (x, y) = (X/Z, Y/Z).
struct Distorted {
  Eigen::Vector2d ray{0, 0};
  Eigen::Matrix2d jacobian = Eigen::Matrix2d::Identity();  // d ray' / d ray
};
Distorted Distort(const Lens& lens, const Eigen::Vector2d& ray) noexcept;

// Returns whether the radial part still rises from the axis out to `ray`: beyond, two rays share a
// pixel.
bool IsInvertibleOutTo(const Lens& lens, const Eigen::Vector2d& ray) noexcept;

// Project() with d p_I / d p_C. False: behind the camera or outside the invertible range.
bool ProjectWithJacobian(const Lens& lens, const Eigen::Vector3d& p_C, Eigen::Vector2d* p_I,
                         Eigen::Matrix<double, 2, 3>* jacobian) noexcept;

// Returns the bias of a tilted dot's image, whose centroid is not the image of the dot's centre:
// centroid of the image of a flat disc minus the image of its centre [px]. A line l of the image (a
// plane through the camera's centre with normal l) touches the disc's edge where
//   (l . c)^2 = r^2 (l . l - (l . n)^2),
// so the dual conic is c c' - r^2 (I - n n'), and the ellipse's centre is its last column. For a
// pinhole this is exact (reference g: x_e = -r^2 sin cos / (Z^2 - r^2 sin^2)); the distortion is
// that at the ellipse's centre. `p_C` centre [m], `n_C` unit normal, camera frame, `radius` [m].
// nullopt: behind the camera, or the disc reaches the plane of the camera's centre.
std::optional<Eigen::Vector2d> CircleCentroidBias(const Lens& lens, const Eigen::Vector3d& p_C,
                                                  const Eigen::Vector3d& n_C,
                                                  double radius) noexcept;

}  // namespace palpate
