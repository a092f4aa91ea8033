#include "slave/study/shape/cloud_picture.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include <opencv2/imgproc.hpp>

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
  Vector3d sum = Vector3d::Zero();
  double count = 0;
  for (const auto& p : points_S) {
    if (p.allFinite()) sum += p, count += 1;
  }
  if (count == 0) return view;
  const Vector3d middle_S = sum / count;
  constexpr double kSteep = 0.8;
  const bool looks_steeply = std::abs(X_SD.linear()(2, 2)) > kSteep;
  const Eigen::AngleAxisd round(turn,
                                looks_steeply ? Vector3d(X_SD.linear().col(0)) : Vector3d::UnitZ());
  view.X_SV = Eigen::Translation3d(middle_S) * round * Eigen::Translation3d(-middle_S) * X_SD;
  const Vector3d middle_V = view.X_SV.inverse() * middle_S;
  view.X_SV = view.X_SV * Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), middle_V);

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

struct CloudPicture::Canvas {
  PictureView view;
  Eigen::Isometry3d X_VS;
  cv::Mat pixels;

  void Line(const Vector3d& a_S, const Vector3d& b_S, const cv::Scalar& colour) {
    const auto a = Pixel(view, X_VS * a_S), b = Pixel(view, X_VS * b_S);
    if (a && b) cv::line(pixels, *a, *b, colour, 1, cv::LINE_AA);
  }
};

CloudPicture::CloudPicture(const PictureView& view)
    : canvas_(std::make_unique<Canvas>(
          Canvas{view, view.X_SV.inverse(),
                 cv::Mat(view.size[1], view.size[0], CV_8UC3, cv::Scalar(255, 255, 255))})) {}

CloudPicture::~CloudPicture() = default;

void CloudPicture::Points(std::span<const Vector3d> points_S, std::span<const Rgb> colours,
                          int size) {
  if (colours.empty()) return;
  std::vector<Vector3d> points_V;
  for (const auto& p : points_S) points_V.emplace_back(canvas_->X_VS * p);
  std::vector<std::size_t> order(points_V.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  // Far ones first. What is not finite has no place in an order; it is not drawn.
  std::erase_if(order, [&](std::size_t i) { return !points_V[i].allFinite(); });
  std::ranges::sort(order, std::greater<>(), [&](std::size_t i) { return points_V[i].z(); });
  for (const std::size_t i : order) {
    const auto at = Pixel(canvas_->view, points_V[i]);
    if (!at) continue;
    const cv::Rect square(at->x - size / 2, at->y - size / 2, size, size);
    cv::rectangle(canvas_->pixels, square, ToCv(colours[colours.size() == 1 ? 0 : i]), cv::FILLED);
  }
}

void CloudPicture::Wires(const SurfaceMesh& surface_S, Rgb colour) {
  for (const auto& triangle : surface_S.triangles) {
    const auto node = [&](std::size_t k) -> const Vector3d& {
      return surface_S.nodes[static_cast<std::size_t>(triangle[k])];
    };
    const Vector3d n = (node(1) - node(0)).cross(node(2) - node(0));
    if (!(n.dot(node(0) - canvas_->view.X_SV.translation()) < 0)) continue;
    for (std::size_t k = 0; k < 3; ++k) canvas_->Line(node(k), node((k + 1) % 3), ToCv(colour));
  }
}

void CloudPicture::Capsules(std::span<const Occluder> capsules_S, Rgb colour) {
  for (const auto& [a, b, radius] : capsules_S) {
    const Vector3d a_V = canvas_->X_VS * a, b_V = canvas_->X_VS * b;
    const auto from = Pixel(canvas_->view, a_V), to = Pixel(canvas_->view, b_V);
    if (!from || !to) continue;
    constexpr double kWidest = 1000;  // [px]
    const double width = 2 * radius * canvas_->view.focal / (0.5 * (a_V.z() + b_V.z()));
    cv::line(canvas_->pixels, *from, *to, ToCv(colour),
             static_cast<int>(std::clamp(width, 1.0, kWidest)), cv::LINE_AA);
  }
}

void CloudPicture::Boxes(std::span<const Vector3d> corners_S, double edge, Rgb colour) {
  for (const auto& corner : corners_S) {
    for (int axis = 0; axis < 3; ++axis) {
      for (int side = 0; side < 4; ++side) {
        Vector3d from = corner;
        from[(axis + 1) % 3] += edge * (side & 1);
        from[(axis + 2) % 3] += edge * (side >> 1);
        canvas_->Line(from, from + edge * Vector3d::Unit(axis), ToCv(colour));
      }
    }
  }
}

std::string CloudPicture::Png() const {
  return EncodePng(canvas_->pixels);
}

}  // namespace palpate::study
