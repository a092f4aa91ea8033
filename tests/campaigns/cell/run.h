// A press that is simulated once: its samples and the true state at each.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "slave/capture/frame_source.h"
#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"
#include "slave/simulator/environment/simulated_environment.h"

namespace palpate::campaign {

// Number of samples of each part of a press.
struct Counts {
  std::size_t rest = 0, in = 0, hold = 0, back = 0, after = 0;

  [[nodiscard]] std::size_t all() const { return rest + in + hold + back + after; }
  // Returns the fraction of the full indentation at this sample, 0 to 1.
  [[nodiscard]] double WayAt(std::size_t index) const;
};

// Places of the parts in an image [px].
struct View {
  Eigen::Vector2d tip{0, 0};      // the tool's tip; for pairs: the pressed point
  Eigen::Vector2d pressed{0, 0};  // position of the tip at full depth
  Eigen::Vector2d shaft{0, -1};   // unit, from the tip along the tool's shaft
  double width = 0;               // of the tool [px]
};

struct Shot {
  cv::Mat left, right;  // images; one camera uses `left` only
  TactileFrame touch;
  Truth truth;
  std::array<View, 2> views;  // of left and right
};

struct Run {
  Scene scene;
  std::vector<Shot> shots;
  double pixel = 1;      // edge of a pixel where the tool is [m]; 1: no images
  nlohmann::json space;  // of a pair: what maps points of space to its images
};

// `moves`: rigid displacement of the object in each image [px]; the images are not shifted back.
Run RunOfCamera(const Scene& scene, const Counts& counts,
                const std::vector<Eigen::Vector2d>& moves);
Run RunOfPair(const Scene& scene, const Counts& counts);
// Depth images of the membrane that a pair of cameras sees in `scene`.
Run RunOfDepth(const Scene& scene, const Counts& counts);
Run RunOfTouch(const Scene& scene, const Counts& counts, bool coarse);

}  // namespace palpate::campaign
