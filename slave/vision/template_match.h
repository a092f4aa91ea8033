// Finds a template in a window: scores of all positions, then the best one to a small part of a
// pixel.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/vision/grey.h"

namespace palpate {

// Scores of all positions (upper left corners) of a template in a window, [-1, 1].
using ScoreMap = cv::Mat_<float>;

// Normalised cross-correlation of a template with every place of a window.
//
//   C(x, y) = sum T~ I~ / sqrt(sum T~^2 sum I~^2),   T~ = T - mean of T,
//   I~ = I - mean of I under the template (at each place again)
//
// Source: paper A, eq. (1), with the two means the right way round (the sentence below the printed
// equation swaps them). Invariant to a gain > 0 and an offset of the light.
class Ncc {
 public:
  // Throws std::invalid_argument: an empty template, or one without contrast.
  explicit Ncc(GreyPatch pattern);

  // Scores every position of `window`; an empty map if the template is larger. 0 where the window
  // has no contrast. Not thread-safe.
  const ScoreMap& Match(const GreyPatch& window);
  // At one position, which is inside: faster than a map for a few positions of a small template.
  [[nodiscard]] double At(const GreyPatch& window, int x, int y) const;

  [[nodiscard]] const GreyPatch& pattern() const { return pattern_; }
  [[nodiscard]] const ScoreMap& map() const { return map_; }  // of the last window

 private:
  GreyPatch pattern_;
  double mean_ = 0, contrast_ = 0;  // of the template's levels; sum T~^2
  cv::Mat levels_;                  // of the template, as cv::matchTemplate takes them
  ScoreMap map_;
};

// Vertex of the parabola through three equally spaced values.
struct Vertex {
  double offset = 0;  // from the middle value, in steps; 0 if the three are on a line
  double value = 0;   // at the vertex
};

//   offset = (y_m - y_p) / (2 (y_m - 2 y_0 + y_p)),   value = y_0 - (y_m - y_p) offset / 4
//
// with y_0 an extremum of the three, so that |offset| <= 1/2. Real-time safe.
constexpr Vertex FitParabola(double y_m, double y_0, double y_p) noexcept {
  const double bend = y_m - 2 * y_0 + y_p;
  if (bend == 0) return {0, y_0};
  const double offset = (y_m - y_p) / (2 * bend);
  return {offset, y_0 - (y_m - y_p) * offset / 4};
}

// Finds a template's place to a small part of a pixel, from a start within about a pixel of it.
//
// Least squares over shift p, gain a and offset b:   sum w (I(x + p) - a T(x) - b)^2 -> min
// by Gauss-Newton with the template's gradients (the inverse compositional form of S. Baker and
// I. Matthews, IJCV 56, 2004). The gradients are made orthogonal to T and 1 beforehand, so that
// gain and offset drop out:   p <- p - H^-1 sum w g'(x) I(x + p) / a,   H = sum w g' g'^T.
//
// A parabola through three correlation scores is biased towards whole pixels; this is not, to
// first order, since the error of linear interpolation is even about an edge and g' is odd.
class TemplateAligner {
 public:
  struct Result {
    bool converged = false;
    Eigen::Vector2d p{0, 0};  // position of the template's upper left pixel in the window [px]
    double sigma = 0;         // one standard deviation, the worse axis, from the residual [px]
    double covered = 0;       // part of the template that something else hides [0, 1]
  };

  // `weights`: one per pixel of `pattern`, >= 0; the outermost ring is not used (it has no central
  // difference).
  TemplateAligner(const GreyPatch& pattern, std::span<const float> weights);

  // Real-time safe. Not thread-safe (it stores the interpolated pixels).
  Result Align(const GreyPatch& window, const Eigen::Vector2d& start) noexcept;
  // The same by iteratively reweighted squares (Tukey): changed parts, such as a reflection, a wire
  // or the edge of a shadow, are excluded. `trust`: one per pixel, 0 for those excluded at first;
  // empty: all.
  Result AlignAround(const GreyPatch& window, const Eigen::Vector2d& start,
                     std::span<const float> trust) noexcept;

  // H without gain and offset, per squared grey level [1/px^2]: white noise of sigma levels in the
  // image moves p by sigma sqrt(H^-1).
  [[nodiscard]] const Eigen::Matrix2d& information() const { return information_; }
  // False: some direction is not determined at all, for example along a bar without marks.
  [[nodiscard]] bool determined() const { return determined_; }

 private:
  using Fit = Eigen::Vector4d;  // of the image by g_x, g_y, T~ and 1

  void Interpolate(const GreyPatch& window, const Eigen::Vector2d& p) noexcept;
  [[nodiscard]] bool IsInside(const GreyPatch& window, const Eigen::Vector2d& p) const noexcept;
  void Reweigh(const Fit& fit) noexcept;
  [[nodiscard]] Fit Regress() noexcept;
  void Assess(const Fit& fit, Result& result) const noexcept;

  int width_, height_;
  float mean_ = 0;       // of the template, subtracted from the image as well, for precision
  double weight_ = 0;    // sum of the weights
  double contrast_ = 0;  // sum w T~^2
  Eigen::MatrixX3f projections_;  // pixels x 3: w g'_x, w g'_y, w T~
  Eigen::VectorXf weights_;       // pixels
  Eigen::VectorXf levels_;        // pixels, interpolated
  Eigen::Matrix<float, Eigen::Dynamic, 4, Eigen::RowMajor> basis_;  // pixels x 4: g_x, g_y, T~, 1
  Eigen::VectorXf trust_;                                // pixels: weights of the last round
  Eigen::Vector4d variances_ = Eigen::Vector4d::Zero();  // of the last fit, per noise^2
  std::vector<float> errors_;                            // pixels
  Eigen::Matrix2d information_, covariance_;
  bool determined_ = false;
};

}  // namespace palpate
