#include "slave/study/shape/shape_pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::study {
namespace {

constexpr Rgb kGrey{205, 210, 218}, kFinger{228, 230, 235}, kGreen{47, 158, 98}, kRed{209, 40, 60},
    kWire{224, 112, 28};

// Near is dark, far is light.
std::vector<Rgb> ByDepth(const PictureView& view, std::span<const Eigen::Vector3d> points_S) {
  const Eigen::Isometry3d X_VS = view.X_SV.inverse();
  std::vector<double> depth;
  double near = std::numeric_limits<double>::infinity(), far = 0;
  for (const auto& p : points_S) {
    depth.push_back((X_VS * p).z());
    near = std::min(near, depth.back());
    far = std::max(far, depth.back());
  }
  std::vector<Rgb> colours;
  for (const double z : depth) {
    const double t = far > near ? (z - near) / (far - near) : 0;
    const auto mix = [&](double a, double b) {
      return static_cast<std::uint8_t>(std::lround(a + t * (b - a)));
    };
    colours.push_back({mix(20, 190), mix(50, 215), mix(110, 240)});
  }
  return colours;
}

}  // namespace

std::string PictureOfCloud(const PictureView& view, const PointCloud& cloud_S) {
  CloudPicture picture(view);
  picture.Points(cloud_S.points,
                 cloud_S.colours.empty() ? ByDepth(view, cloud_S.points) : cloud_S.colours);
  return picture.Png();
}

std::string PictureOfRegions(const PictureView& view, const PointCloud& cloud_S,
                             const Segmentation& segmentation) {
  std::vector<Rgb> colours;
  for (const int region : segmentation.region_of) {
    colours.push_back(region < 0 ? kGrey : RegionColour(region));
  }
  CloudPicture picture(view);
  picture.Points(cloud_S.points, colours);
  return picture.Png();
}

std::string PictureOfShapes(const PictureView& view, std::span<const Eigen::Vector3d> measured_S,
                            const SurfaceMesh& estimate_S, std::span<const Occluder> fingers_S) {
  CloudPicture picture(view);
  picture.Capsules(fingers_S, kFinger);
  picture.Points(measured_S, ByDepth(view, measured_S), 3);
  picture.Wires(estimate_S, kWire);
  return picture.Png();
}

std::string PictureOfLeaves(const PictureView& view, std::span<const Eigen::Vector3d> measured_S,
                            std::span<const Eigen::Vector3d> simulated_S, double leaf) {
  const OctreeLeaves leaves(measured_S, leaf, LatticeCorners(measured_S, leaf).front());
  std::vector<Rgb> colours;
  for (const auto& p : simulated_S) colours.push_back(leaves.Contains(p) ? kGreen : kRed);
  CloudPicture picture(view);
  picture.Boxes(leaves.corners(), leaf, kGrey);
  picture.Points(simulated_S, colours, 3);
  return picture.Png();
}

}  // namespace palpate::study
