// From images to tool tip and contour (paper A, 3.2). Owns the trackers; independent of forces.
#pragma once

#include <memory>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/vision/observation.h"

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
  // an observation with nothing found; never throws. Call from one thread.
  const Observation& Process(const cv::Mat& image, std::uint64_t sequence, Time sensed_at) noexcept;

  // Contour of the object at rest in the first image, refined to sub-pixel accuracy along its
  // normals [px], counter-clockwise in S. Empty if the scene tracks no contour.
  [[nodiscard]] const std::vector<Eigen::Vector2d>& rest_contour_I() const;
  // Direction of the tool in the image, unit length; zero: unknown.
  [[nodiscard]] Eigen::Vector2d tool_direction_I() const;
  // Noise of the first image, one standard deviation [1/255 of full scale].
  [[nodiscard]] double noise() const;
  // Search window of the tip [px], for overlays.
  [[nodiscard]] cv::Rect search_window() const;
  // Searches the whole next image and starts the contour again.
  void Reset() noexcept;
  // The object has sprung back: its contour is searched at its position in the first image.
  void RestartContour() noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
