// Finds a template's place to a small part of a pixel, from a start within about a pixel of it.
//
// Least squares over shift p, gain a and offset b:   sum w (I(x + p) - a T(x) - b)^2 -> min
// by Gauss-Newton with the template's gradients (the inverse compositional form of S. Baker and
// I. Matthews, IJCV 56, 2004). The gradients are made orthogonal to T and 1 beforehand, so that
// gain and offset drop out:   p <- p - H^-1 sum w g'(x) I(x + p) / a,   H = sum w g' g'^T.
//
// A parabola through three correlation scores is biased towards whole pixels; this is not, to
// first order, since the error of linear interpolation is even about an edge and g' is odd.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/vision/grey.h"

namespace palpate {

class TemplateAligner {
 public:
  struct Result {
    bool converged = false;
    Eigen::Vector2d p{0, 0};  // place of the template's upper left pixel in the window [px]
    double sigma = 0;         // one standard deviation, the worse axis, from the residual [px]
  };

  // `weights`: one per pixel of `pattern`, >= 0; the outermost ring is not used (it has no central
  // difference).
  TemplateAligner(const GreyPatch& pattern, std::span<const float> weights);

  // Real-time safe. Not thread-safe (it keeps the interpolated pixels).
  Result Align(const GreyPatch& window, const Eigen::Vector2d& start) noexcept;

  // H without gain and offset, per squared grey level [1/px^2]: white noise of sigma levels in the
  // picture moves p by sigma sqrt(H^-1).
  [[nodiscard]] const Eigen::Matrix2d& information() const { return information_; }
  // False: some direction is not determined at all, for example along a bar without marks.
  [[nodiscard]] bool determined() const { return determined_; }

 private:
  void Interpolate(const GreyPatch& window, const Eigen::Vector2d& p) noexcept;

  int width_, height_;
  float mean_ = 0;                // of the template, taken off the picture too, for precision
  double weight_ = 0;             // sum of the weights
  double contrast_ = 0;           // sum w T~^2
  Eigen::MatrixX3f projections_;  // pixels x 3: w g'_x, w g'_y, w T~
  Eigen::VectorXf weights_;       // pixels
  Eigen::VectorXf levels_;        // pixels, interpolated
  Eigen::Matrix2d information_, covariance_;
  bool determined_ = false;
};

}  // namespace palpate
