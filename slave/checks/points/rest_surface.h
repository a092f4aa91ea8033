// The surface at rest against the body of the scene: where a depth camera or a pair sees it, how it
// is tilted, and how far it extends. Depths of a wrong unit, intrinsics of another stream or image
// size, and a camera that is elsewhere than stated show in at least one of them.
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

// The measured surface at rest against the scene's body, by the rays that meet the body.
struct RestSurface {
  double distance = 0;              // of the body by the scene, along the camera's axis [m]
  double off = 0, sigma_off = 0;    // how much farther it is seen [m]
  double tilt = 0, sigma_tilt = 0;  // of what is seen against the scene [rad]
  double edge = 1;  // share of the body's edge that is seen, by that of its middle, least side [-]
  double beyond = 0;  // share of the rays just outside that see the surface go on, of both sides
                      // along an axis the lesser, of both axes the greater [-]
  std::string_view fault{};  // why the estimate cannot be trusted, static; empty: it can
  bool meets = false;        // rays meet the body and see something there
};

// RestRay is one ray of the camera with its measurement. Camera frame.
struct RestRay {
  Eigen::Vector2d slope{0, 0};  // x/z, y/z
  double z = 0;                 // depth along the axis [m]; 0: none
};

// `surface_C`: of the scene's body, outward, camera frame. `rays`: in rows of `columns`; 0:
// anywhere, which shows no extent. `sigma`: of one depth [m]; `independent`: depths that err alike
// count as one of so many rays.
RestSurface CompareAtRest(const SurfaceMesh& surface_C, const std::vector<RestRay>& rays,
                          int columns, double sigma, double independent);

// Returns why the estimate cannot be trusted; empty: it can. `size` of the body [m].
std::string_view FaultOf(const RestSurface& rest, double size);

class RestSurfaceCheck final : public Check<PointsSample> {
 public:
  // `surface_O`: of the scene's body. `result`: gets what was compared; it must outlive the check.
  RestSurfaceCheck(const Scene& scene, SurfaceMesh surface_O, std::optional<RestSurface>* result);

  // Decides by the first points that are found: all samples are flagged, or none.
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
