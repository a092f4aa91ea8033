#include "tests/slave/vision/test_images.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <opencv2/core.hpp>

#include "tests/support/normal_noise.h"

namespace palpate {
namespace {

// Returns the part of a pixel that is inside, from its signed distance to an edge (positive
// inside).
double Inside(double distance, double blur) {
  return 0.5 * std::erfc(-distance / (std::sqrt(2.0) * blur));
}

double Texture(const Eigen::Vector2d& q) {
  return (std::sin(0.31 * q.x() + 0.17 * q.y()) + std::sin(0.23 * q.y() - 0.41 * q.x() + 1) +
          std::sin(0.77 * q.x() + 0.59 * q.y() + 2)) /
         3;
}

double Coverage(const PaintedBody& body, const Eigen::Vector2d& q, double blur) {
  if (body.shape == PaintedBody::Shape::kDisc) return Inside(body.half.x() - q.norm(), blur);
  return Inside(body.half.x() - q.x(), blur) * Inside(body.half.x() + q.x(), blur) *
         Inside(body.half.y() - q.y(), blur) * Inside(body.half.y() + q.y(), blur);
}

// Three pale bands and a few dots, fixed to the tool.
double Marks(double behind, double aside) {
  double level = 0;
  for (const double at : {7.0, 19.0, 24.0, 38.0}) {
    level += 70 * std::exp(-0.5 * std::pow((behind - at) / 1.6, 2));
  }
  for (const Eigen::Vector2d& dot : {Eigen::Vector2d(13, 3), Eigen::Vector2d(30, -4)}) {
    level += 60 * std::exp(-0.5 * (Eigen::Vector2d(behind, aside) - dot).squaredNorm() / 2.5);
  }
  return level;
}

}  // namespace

double TestImage::LevelAt(double x, double y) const {
  double level = background;
  const Eigen::Vector2d p(x, y);
  if (body) {
    const double c = std::cos(body->angle), s = std::sin(body->angle);
    const Eigen::Vector2d d = p - body->centre;
    const Eigen::Vector2d q(c * d.x() + s * d.y(), -s * d.x() + c * d.y());
    const double cover = Coverage(*body, q, blur);
    level += cover * (body->level + body->texture * Texture(q) - level);
  }
  if (tool) {
    const Eigen::Vector2d d = p - tool->tip;
    const double behind = -d.dot(tool->direction);
    const double aside = d.x() * tool->direction.y() - d.y() * tool->direction.x();
    const double cover = Inside(behind, blur) * Inside(0.5 * tool->width - aside, blur) *
                         Inside(0.5 * tool->width + aside, blur);
    level +=
        cover * (tool->level + (tool->marks ? tool->contrast * Marks(behind, aside) : 0) - level);
  }
  return level * (1 - lighting * x / size.width);
}

cv::Mat TestImage::Render(std::uint64_t seed, int type, double full_scale) const {
  std::mt19937_64 random(seed);
  NormalNoise normal;
  const bool deep = CV_MAT_DEPTH(type) == CV_16U;
  const double scale = deep ? full_scale / 255 : 1;
  cv::Mat image(size, type);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double grey = LevelAt(x, y) + noise * normal(random);
      const double value = std::clamp(std::round(scale * grey), 0.0, 255 * scale);
      for (int c = 0; c < image.channels(); ++c) {
        if (deep) {
          image.ptr<ushort>(y)[x * image.channels() + c] = static_cast<ushort>(value);
        } else {
          image.ptr<uchar>(y)[x * image.channels() + c] = static_cast<uchar>(value);
        }
      }
    }
  }
  return image;
}

Scene SceneForTestImages() {
  Scene scene;
  scene.name = "test images";
  scene.tool.emplace();
  scene.tool->width = 0.017;
  scene.sense.Set(CameraOptions{Camera{.pixel = 0.001}, TipTracking{}, ContourTracking{}});
  return scene;
}

}  // namespace palpate
