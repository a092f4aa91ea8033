// The object's contour in the first image and the tool's tip in every one (paper A, 3.2).
#pragma once

#include <memory>
#include <optional>

#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/vision/observation.h"
#include "slave/vision/rest_contour.h"

namespace palpate {

class TipAndContourTracker {
 public:
  // `first`: the first image, with the object at rest. `tip_hint_I`: tip position from the encoders
  // [px], used to cut the template if the scene has no file; nullopt: unknown (then a template file
  // is needed). Throws std::runtime_error naming file or key: unreadable template, template larger
  // than the image, flat template, no contour found, contour collapsed, depth or channel count not
  // supported.
  TipAndContourTracker(const Scene& scene, const cv::Mat& first,
                       std::optional<Eigen::Vector2d> tip_hint_I);
  ~TipAndContourTracker();

  // Processes one image. An image of another size or depth than the first, or an empty one, gives
  // an observation in which nothing is found; never throws. Call from one thread.
  const TipObservation& Process(const cv::Mat& image) noexcept;

  // Returns the outline of the object at rest in the first image, counter-clockwise in S. Empty if
  // the scene tracks no contour.
  [[nodiscard]] const RestContour& rest_contour() const;
  // Returns the direction of the tool in the image, unit length; zero: unknown.
  [[nodiscard]] Eigen::Vector2d tool_direction_I() const;
  // Returns the noise of the first image, one standard deviation [1/255 of full scale].
  [[nodiscard]] double noise() const;
  // Returns the search window of the tip [px], for overlays.
  [[nodiscard]] cv::Rect search_window() const;
  // Searches the whole next image.
  void Reset() noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
