// Clouds, surfaces and boxes as pictures.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/solid_mesh.h"
#include "slave/study/shape/virtual_depth_camera.h"

namespace palpate::study {

using Rgb = std::array<std::uint8_t, 3>;

// Well distinguishable on white; goes round.
Rgb RegionColour(int region);

// Looks along z of V, x right, y down, from V's origin.
struct PictureView {
  Eigen::Isometry3d X_SV = Eigen::Isometry3d::Identity();
  double focal = 500;                 // [px]
  Eigen::Vector2d centre{320, 240};   // where z meets the picture [px]
  std::array<int, 2> size{640, 480};  // [px]
};
// From where `X_SD` stands, aimed and zoomed so that `points_S` fill the picture; `turn` [rad] goes
// round their middle first, about S's vertical z, or, for who looks down or up, over the top. No
// points: straight ahead.
PictureView ViewOf(const Eigen::Isometry3d& X_SD, std::span<const Eigen::Vector3d> points_S,
                   double turn = 0);

class CloudPicture {
 public:
  // White.
  explicit CloudPicture(const PictureView& view);
  ~CloudPicture();

  // Squares of `size` pixels; `colours`: one for all, or one each. Near ones hide far ones of the
  // same call; later calls draw over earlier ones. Points behind the view or not finite: none.
  void Points(std::span<const Eigen::Vector3d> points_S, std::span<const Rgb> colours,
              int size = 2);
  // Edges of triangles that face the view.
  void Wires(const SurfaceMesh& surface_S, Rgb colour);
  // Thick lines with round ends.
  void Capsules(std::span<const Occluder> capsules_S, Rgb colour);
  // Edges of cubes.
  void Boxes(std::span<const Eigen::Vector3d> corners_S, double edge, Rgb colour);
  [[nodiscard]] std::string Png() const;

 private:
  struct Canvas;
  std::unique_ptr<Canvas> canvas_;
};

}  // namespace palpate::study
