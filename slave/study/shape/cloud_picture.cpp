#include "slave/study/shape/cloud_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include <opencv2/imgproc.hpp>

#include "shared/geometry/rotation_between.h"
#include "slave/capture/codecs/codecs.h"

namespace palpate::study {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNearest = 1e-3;  // [m]

cv::Scalar ToCv(const Rgb& colour) {
  return {static_cast<double>(colour[2]), static_cast<double>(colour[1]),
          static_cast<double>(colour[0])};
}

// nullopt: behind the view, not finite, or far outside the picture.
std::optional<cv::Point> Pixel(const PictureView& view, const Vector3d& p_V) {
  if (!(p_V.z() > kNearest)) return std::nullopt;
  const Vector2d at = view.centre + view.focal * p_V.head<2>() / p_V.z();
  if (!(at.cwiseAbs().maxCoeff() < 1e4)) return std::nullopt;
  return cv::Point(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())));
}

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

class CloudPicture {
 public:
  // White.
  explicit CloudPicture(const PictureView& view)
      : view_(view),
        X_VS_(view.X_SV.inverse()),
        pixels_(view.size[1], view.size[0], CV_8UC3, cv::Scalar(255, 255, 255)) {}

  // Squares of `size` pixels; `colours`: one for all, or one each. Near ones hide far ones of the
  // same call; later calls draw over earlier ones. Points behind the view or not finite: none.
  void Points(std::span<const Vector3d> points_S, std::span<const Rgb> colours, int size = 2) {
    if (colours.empty()) return;
    std::vector<Vector3d> points_V;
    for (const auto& p : points_S) points_V.emplace_back(X_VS_ * p);
    std::vector<std::size_t> order(points_V.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    // Far ones first. What is not finite has no place in an order; it is not drawn.
    std::erase_if(order, [&](std::size_t i) { return !points_V[i].allFinite(); });
    std::ranges::sort(order, std::greater<>(), [&](std::size_t i) { return points_V[i].z(); });
    for (const std::size_t i : order) {
      const auto at = Pixel(view_, points_V[i]);
      if (!at) continue;
      const cv::Rect square(at->x - size / 2, at->y - size / 2, size, size);
      cv::rectangle(pixels_, square, ToCv(colours[colours.size() == 1 ? 0 : i]), cv::FILLED);
    }
  }

  // Edges of triangles that face the view.
  void Wires(const SurfaceMesh& surface_S, Rgb colour) {
    for (const auto& triangle : surface_S.triangles) {
      const auto node = [&](std::size_t k) -> const Vector3d& {
        return surface_S.nodes[static_cast<std::size_t>(triangle[k])];
      };
      const Vector3d n = (node(1) - node(0)).cross(node(2) - node(0));
      if (!(n.dot(node(0) - view_.X_SV.translation()) < 0)) continue;
      for (std::size_t k = 0; k < 3; ++k) Line(node(k), node((k + 1) % 3), ToCv(colour));
    }
  }

  // Thick lines with round ends.
  void Capsules(std::span<const Occluder> capsules_S, Rgb colour) {
    for (const auto& [a, b, radius] : capsules_S) {
      const Vector3d a_V = X_VS_ * a, b_V = X_VS_ * b;
      const auto from = Pixel(view_, a_V), to = Pixel(view_, b_V);
      if (!from || !to) continue;
      constexpr double kWidest = 1000;  // [px]
      const double width = 2 * radius * view_.focal / (0.5 * (a_V.z() + b_V.z()));
      cv::line(pixels_, *from, *to, ToCv(colour), static_cast<int>(std::clamp(width, 1.0, kWidest)),
               cv::LINE_AA);
    }
  }

  // Edges of cubes.
  void Boxes(std::span<const Vector3d> corners_S, double edge, Rgb colour) {
    for (const auto& corner : corners_S) {
      for (int axis = 0; axis < 3; ++axis) {
        for (int side = 0; side < 4; ++side) {
          Vector3d from = corner;
          from[(axis + 1) % 3] += edge * (side & 1);
          from[(axis + 2) % 3] += edge * (side >> 1);
          Line(from, from + edge * Vector3d::Unit(axis), ToCv(colour));
        }
      }
    }
  }

  [[nodiscard]] std::string Png() const { return EncodePng(pixels_); }

 private:
  void Line(const Vector3d& a_S, const Vector3d& b_S, const cv::Scalar& colour) {
    const auto a = Pixel(view_, X_VS_ * a_S), b = Pixel(view_, X_VS_ * b_S);
    if (a && b) cv::line(pixels_, *a, *b, colour, 1, cv::LINE_AA);
  }

  PictureView view_;
  Eigen::Isometry3d X_VS_;
  cv::Mat pixels_;
};

}  // namespace

Rgb RegionColour(int region) {
  static constexpr std::array<Rgb, 10> kColours{{{47, 111, 214},
                                                 {224, 112, 28},
                                                 {47, 158, 98},
                                                 {166, 79, 201},
                                                 {201, 138, 0},
                                                 {20, 154, 168},
                                                 {209, 69, 69},
                                                 {118, 128, 143},
                                                 {120, 86, 60},
                                                 {230, 120, 180}}};
  return kColours[static_cast<std::size_t>(std::max(0, region)) % kColours.size()];
}

PictureView ViewOf(const Eigen::Isometry3d& X_SD, std::span<const Vector3d> points_S, double turn) {
  PictureView view;
  view.X_SV = X_SD;
  if (std::ranges::none_of(points_S, [](const auto& p) { return p.allFinite(); })) return view;
  const Vector3d middle_S = CentroidOf(points_S);
  constexpr double kSteep = 0.8;
  const bool looks_steeply = std::abs(X_SD.linear()(2, 2)) > kSteep;
  const Eigen::AngleAxisd round(turn,
                                looks_steeply ? Vector3d(X_SD.linear().col(0)) : Vector3d::UnitZ());
  view.X_SV = Eigen::Translation3d(middle_S) * round * Eigen::Translation3d(-middle_S) * X_SD;
  const Vector3d middle_V = view.X_SV.inverse() * middle_S;
  view.X_SV.rotate(RotationBetween(Vector3d::UnitZ(), middle_V));

  double reach = 1e-9;  // largest tangent of the angle to a point
  const Eigen::Isometry3d X_VS = view.X_SV.inverse();
  for (const auto& p : points_S) {
    const Vector3d p_V = X_VS * p;
    if (!(p_V.z() > kNearest)) continue;
    const Vector2d tangent = (p_V.head<2>() / p_V.z()).cwiseAbs();
    reach = std::max({reach, tangent.x() * view.size[1] / view.size[0], tangent.y()});
  }
  constexpr double kMargin = 0.9;
  view.focal = kMargin * 0.5 * view.size[1] / reach;
  return view;
}

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
