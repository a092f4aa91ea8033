// Pictures -> tool tip and contour (paper A, 3.2). Owns the trackers; knows nothing of forces.
#pragma once

#include <memory>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/vision/observation.h"

namespace palpate {

class TipAndContourTracker {
 public:
  // `first`: the first picture, in which the object rests. `tip_hint_I`: where the manipulator says
  // the tip is [px], used to cut the template when the scene names none; nullopt: unknown (then a
  // template file is needed). Throws std::runtime_error naming file or key: unreadable template,
  // template larger than the picture, flat template, no contour found, contour collapsed, depth or
  // channel count not supported.
  TipAndContourTracker(const Scene& scene, const cv::Mat& first,
                       std::optional<Eigen::Vector2d> tip_hint_I);
  ~TipAndContourTracker();

  // Looks at one picture. A picture of another size or depth than the first, or an empty one, gives
  // an observation with nothing found; never throws. Call from one thread.
  const Observation& Process(const cv::Mat& image, std::uint64_t sequence, Time sensed_at) noexcept;

  // Contour of the resting object found in the first picture, refined to sub-pixel along its
  // normals [px], counter-clockwise as seen in S. Empty if the scene tracks no contour.
  [[nodiscard]] const std::vector<Eigen::Vector2d>& rest_contour_I() const;
  // Along which the tool points in the picture, unit length; zero: nobody knows.
  [[nodiscard]] Eigen::Vector2d tool_direction_I() const;
  // Of the first picture, one standard deviation [1/255 of full scale].
  [[nodiscard]] double noise() const;
  // Search window of the tip [px], for overlays.
  [[nodiscard]] cv::Rect search_window() const;
  // Search the whole picture next time and start the contour anew.
  void Reset() noexcept;
  // The object has sprung back: its contour is looked for where it was in the first picture.
  void RestartContour() noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
