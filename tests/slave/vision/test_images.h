// Images with exactly known subpixel positions: a body and a bar-shaped tool on a plain background.
// Every edge is an error function (a blurred step) in closed form.
#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"

namespace palpate {

struct PaintedBody {
  enum class Shape { kRectangle, kDisc } shape = Shape::kRectangle;
  Eigen::Vector2d centre{320, 300};  // [px]
  Eigen::Vector2d half{110, 100};    // half edges [px]; disc: radius in x
  double angle = 0;                  // [rad], clockwise in the image
  double level = 120;
  double texture = 8;  // amplitude [grey levels]
};

struct PaintedTool {
  Eigen::Vector2d tip{320, 160};  // [px]
  Eigen::Vector2d direction{0, 1};
  double width = 17;  // [px]
  double level = 60;
  bool marks = true;
  double contrast = 1;  // of the marks
};

struct TestImage {
  cv::Size size{640, 480};
  double background = 200;  // grey levels of 255
  double blur = 0.75;       // sigma of the error functions [px]
  double noise = 2;         // sigma [grey levels of 255]
  double lighting = 0;      // relative fall of the light from left to right

  std::optional<PaintedBody> body;
  std::optional<PaintedTool> tool;

  // `type`: CV_8UC1, CV_8UC3, CV_16UC1 or CV_16UC3. 16 bit: `full_scale` is white. The noise of a
  // `seed` is always the same.
  [[nodiscard]] cv::Mat Render(std::uint64_t seed = 1, int type = CV_8UC1,
                               double full_scale = 65535) const;
  // Grey level without noise at a place [px].
  [[nodiscard]] double LevelAt(double x, double y) const;
};

// A scene for such images: 1 mm per pixel, a tool 17 px wide that points down, default tracking of
// tip and contour.
Scene SceneForTestImages();

}  // namespace palpate
