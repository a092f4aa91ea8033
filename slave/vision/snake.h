// Active contour: a closed chain of points that moves to the edge of an object.
//
//   E = sum over the points of alpha E_cont + beta E_curv + gamma E_image            (paper A, eq.
//   2)
//
// minimised greedily: each point in turn moves to the best of its nine places (itself and its
// neighbours), whose energies are normalised over the nine:
//
//   E_cont  = | d - |v_i - v_{i-1}| | / max,    d: mean spacing
//   E_curv  = |v_{i-1} - 2 v_i + v_{i+1}|^2 / max
//   E_image = (min - g) / max(max - min, 5),    g: gradient magnitude; min is lowered to max - 5
//             if the range is below 5, so that noise in a flat region has no effect
//
// Source: D. J. Williams and M. Shah, A fast algorithm for active contours and curvature
// estimation, CVGIP: Image Understanding 55, 1992; beta is 0 at corners as in that paper.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/vision/closed_curve.h"
#include "slave/vision/grey.h"

namespace palpate {

// The nine candidate positions of a point: index 3 (dx + 1) + (dy + 1); 4 is its present position.
using NinePlaces = std::array<double, 9>;

struct GreedyStep {
  NinePlaces cont{}, curv{}, image{}, total{};
  int best = 4;  // its present position, unless another one is strictly better
  [[nodiscard]] int dx() const { return best / 3 - 1; }
  [[nodiscard]] int dy() const { return best % 3 - 1; }
};

struct SnakeWeights {
  double alpha = 1, beta = 1, gamma = 1.2;
};

// Computes one greedy step of the point `v` between its neighbours. `magnitude`: gradient magnitude
// at the nine positions, in 1/255 of full scale.
GreedyStep EvaluateStep(const Eigen::Vector2d& previous, const Eigen::Vector2d& v,
                        const Eigen::Vector2d& next, double mean_spacing,
                        const SnakeWeights& weights, const NinePlaces& magnitude) noexcept;

class Snake {
 public:
  // Starts on `start` [px], resampled to `control_points` whole-pixel positions, at least 2 px
  // inside an image of `format`.
  Snake(const GreyFormat& format, const SnakeWeights& weights, CurveView start, int control_points);

  // Moves at most `max_rounds` times around the chain, until few points move. If some points have
  // slid together and left a gap, the points are spaced evenly again: E_cont alone does not close
  // it, because it hardly differs between the nine positions. Returns the number of rounds. `image`
  // fits the format.
  int Creep(const cv::Mat& image, int max_rounds);

  // Amplifies weak or blurred gradients from now on, near the points (up to 8 times), as Williams &
  // Shah do by scaling those of the whole image.
  void AdaptTo(const cv::Mat& image) noexcept;

  [[nodiscard]] const Curve& points() const { return points_; }  // [px]

 private:
  NinePlaces MagnitudeAround(const cv::Mat& image, const Eigen::Vector2d& v) const noexcept;
  int CreepRound(const cv::Mat& image) noexcept;
  void RelaxCorners() noexcept;
  void EvenOut();
  [[nodiscard]] Eigen::Vector2d Clamped(const Eigen::Vector2d& v) const noexcept;

  GreyFormat format_;
  SnakeWeights weights_;
  double gain_ = 1;  // of gradients
  Curve points_;
  std::vector<double> beta_;      // per point: weights_.beta, 0 at corners
  std::vector<double> strength_;  // gradient magnitude under each point
  std::vector<double> bend_;      // curvature at each point
};

}  // namespace palpate
