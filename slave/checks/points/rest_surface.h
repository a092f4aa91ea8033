// Compares the surface at rest with the body of the scene: its distance, tilt and extent as seen by
// a depth camera or a pair. Depths in a wrong unit, intrinsics of another stream or image size, and
// a wrong camera pose change at least one of them.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "shared/mesh/solid_mesh.h"
#include "slave/checks/check.h"
#include "slave/checks/points/points_sample.h"
#include "slave/scene/scene.h"

namespace palpate {

// Compares the measured surface at rest with the scene's body, using the rays that meet the body.
struct RestSurface {
  double distance = 0;  // distance of the body according to the scene, along the camera's axis [m]
  double off = 0, sigma_off = 0;    // measured minus expected distance [m]
  double tilt = 0, sigma_tilt = 0;  // of the measured surface against the scene [rad]
  // Share of visible points at the body's edge relative to its centre; smallest over the sides [-].
  double edge = 1;
  // Share of the rays just outside of the body that still hit a surface: smaller value of the two
  // sides of an axis, larger value of the two axes [-].
  double beyond = 0;
  std::string_view fault{};  // why the estimate cannot be trusted, static; empty: it can
  bool meets = false;        // whether rays meet the body and measure a surface there
};

// RestRay is one ray of the camera with its measurement. Camera frame.
struct RestRay {
  Eigen::Vector2d slope{0, 0};  // x/z, y/z
  double z = 0;                 // depth along the axis [m]; 0: none
};

// `surface_C`: of the scene's body, outward, camera frame. `rays`: in rows of `columns`; 0: not in
// rows, then the extent is not compared. `sigma`: of one depth [m]; `independent`: number of rays
// with a common depth error.
RestSurface CompareAtRest(const SurfaceMesh& surface_C, const std::vector<RestRay>& rays,
                          int columns, double sigma, double independent);

// Returns why the estimate cannot be trusted; empty: it can. `size` of the body [m].
std::string_view FaultOf(const RestSurface& rest, double size);

class RestSurfaceCheck final : public Check<PointsSample> {
 public:
  // `surface_O`: of the scene's body. `result`: receives the comparison; it must outlive the check.
  RestSurfaceCheck(const Scene& scene, SurfaceMesh surface_O, std::optional<RestSurface>* result);

  // Decides from the first points that are found: either all samples are flagged, or none.
  void Examine(const PointsSample& sample, Findings* findings) noexcept override;
  void Reset() noexcept override { result_->reset(); }

 private:
  SurfaceMesh surface_C_;
  std::optional<DepthImages> depth_;
  Eigen::Isometry3d X_CS_;
  double size_ = 0;  // of the body [m]
  std::optional<RestSurface>* result_;
};

}  // namespace palpate
