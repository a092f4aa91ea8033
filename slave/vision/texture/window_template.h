// A window of texture that finds itself in another picture.
//
// Sum of squared differences over an affine warp, with gain a and offset b of the light:
//   sum w (I(A u + p) - a T(u) - b)^2 -> min
// by Gauss-Newton with the template's gradients, made orthogonal to T and 1 beforehand so that gain
// and offset drop out (inverse compositional form: S. Baker and I. Matthews, IJCV 56, 2004). Paper
// C tracks shifts only; an approaching or turning organ needs the affine part. The weights w are a
// Gaussian about the centre, whose place is asked for: where the surface bends, what lies further
// out pulls the answer away.
#pragma once

#include <cstddef>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/vision/texture/window_warp.h"

namespace palpate {

class WindowTemplate {
 public:
  enum class Freedom : unsigned char { kShift, kAffine };

  struct Match {
    bool converged = false;
    WindowWarp warp;
    double correlation = -1;  // of window and picture, [-1, 1]
    // Of warp.p, from the residual [px^2].
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  };

  // `edge` odd, 5 to 255 [px]; throws std::invalid_argument. No texture until Cut().
  explicit WindowTemplate(int edge);

  // Takes the texture under `warp`. False, and no texture, where the window leaves the picture or
  // has too little structure to have a place (also where a shift along it changes nothing).
  // Real-time safe.
  bool Cut(const cv::Mat& grey, const WindowWarp& warp,
           Freedom freedom = Freedom::kAffine) noexcept;

  // From within a few pixels of the answer. Real-time safe; not thread-safe (it keeps the
  // interpolated pixels).
  Match Align(const cv::Mat& grey, const WindowWarp& start, Freedom freedom) noexcept;
  // Correlation at one place; -1 outside the picture or where there is no contrast.
  double Score(const cv::Mat& grey, const WindowWarp& warp) noexcept;

  [[nodiscard]] int edge() const { return edge_; }
  [[nodiscard]] bool textured() const { return textured_; }

 private:
  static constexpr int kMost = 6;  // shift x, y; change of x with u, v; of y with u, v
  struct Sums;

  bool Sample(const cv::Mat& grey, const WindowWarp& warp, int ring) noexcept;
  void FillBasis(bool affine) noexcept;
  bool Invert(int freedoms) noexcept;
  double WeighLevels() noexcept;
  Sums Project(bool affine) noexcept;

  int edge_;
  std::ptrdiff_t count_;
  bool textured_ = false, affine_ = false;
  float mean_ = 0;         // of the template
  double contrast_ = 0;    // sum T~^2
  Eigen::MatrixXf basis_;  // pixels x 7: gradients g' (shift, affine), T~; times sqrt(w)
  Eigen::VectorXf root_weights_;
  double weight_ = 0;       // sum of the weights
  Eigen::VectorXf levels_;  // as sampled, with a ring around when a template is cut
  Eigen::Matrix2d shift_inverse_ = Eigen::Matrix2d::Zero();
  Eigen::Matrix<double, kMost, kMost> affine_inverse_ = Eigen::Matrix<double, kMost, kMost>::Zero();
};

}  // namespace palpate
