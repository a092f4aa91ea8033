// Windows of texture: their selection, pose and alignment in another image.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace palpate {

// Pose of a window in an image: pixel u of the window (from its centre) is at A u + p.
struct WindowWarp {
  Eigen::Matrix2d A = Eigen::Matrix2d::Identity();
  Eigen::Vector2d p{0, 0};  // the centre [px]; (0, 0) is the centre of the upper left pixel

  // The same window in an image that is `level` times reduced by two.
  [[nodiscard]] WindowWarp OnLevel(int level) const {
    const double scale = 1.0 / (1 << level);
    return {A, ((p.array() + 0.5) * scale - 0.5).matrix()};
  }
  [[nodiscard]] WindowWarp FromLevel(int level) const {
    const double scale = 1 << level;
    return {A, ((p.array() + 0.5) * scale - 0.5).matrix()};
  }
};

// A grey image and its reductions by two: the pyramid in which windows are searched from coarse to
// fine.
class PicturePyramid {
 public:
  // `levels` >= 1; fewer if the image would become smaller than 32 px. Throws
  // std::invalid_argument: not 8 bit, neither grey nor BGR, smaller than 32 px.
  PicturePyramid(const cv::Mat& first, int levels);

  // Loads an image of the first one's size and type; false (and nothing changed) otherwise.
  // Real-time safe.
  bool Read(const cv::Mat& picture) noexcept;

  [[nodiscard]] int levels() const { return static_cast<int>(levels_.size()); }
  [[nodiscard]] const cv::Mat& operator[](int level) const {  // 8 bit grey
    return levels_[static_cast<std::size_t>(level)];
  }

 private:
  int type_ = 0;
  std::vector<cv::Mat> levels_;
};

// Automatic selection of windows: centres [px] of at most `count` windows of `edge` px whose
// structure tensor (sum of grad grad^T over the window) has the largest smaller eigenvalues: J. Shi
// and C. Tomasi, CVPR 1994. At least `apart` from each other, with a window inside the image; best
// first. Empty: no texture, or an unusable image (not 8 bit, neither grey nor BGR).
std::vector<Eigen::Vector2d> ChooseWindows(const cv::Mat& picture, int count, int edge,
                                           double apart);

// A window of texture that finds itself in another image.
//
// Sum of squared differences over an affine warp, with gain a and offset b of the light:
//   sum w (I(A u + p) - a T(u) - b)^2 -> min
// by Gauss-Newton with the template's gradients, made orthogonal to T and 1 beforehand so that gain
// and offset drop out (inverse compositional form: S. Baker and I. Matthews, IJCV 56, 2004). Paper
// C tracks shifts only; an approaching or turning organ needs the affine part. The weights w are a
// Gaussian about the centre, whose place is asked for: where the surface bends, what lies further
// out pulls the solution away.
class WindowTemplate {
 public:
  enum class Freedom : unsigned char { kShift, kAffine };

  struct Match {
    bool converged = false;
    WindowWarp warp;
    double correlation = -1;  // correlation of window and image, [-1, 1]
    // Of warp.p, from the residual [px^2].
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  };

  // `edge` odd, 5 to 255 [px]; throws std::invalid_argument. No texture until Cut().
  explicit WindowTemplate(int edge);

  // Stores the texture under `warp`. False, and no texture, if the window leaves the image or has
  // too little structure for a unique position (also if a shift along it changes nothing).
  // Real-time safe.
  bool Cut(const cv::Mat& grey, const WindowWarp& warp,
           Freedom freedom = Freedom::kAffine) noexcept;

  // Aligns from within a few pixels of the result. Real-time safe; not thread-safe (it stores the
  // interpolated pixels).
  Match Align(const cv::Mat& grey, const WindowWarp& start, Freedom freedom) noexcept;
  // Correlation at one position; -1 outside the image or without contrast.
  double Score(const cv::Mat& grey, const WindowWarp& warp) noexcept;

  [[nodiscard]] int edge() const { return edge_; }
  [[nodiscard]] bool textured() const { return textured_; }

 private:
  static constexpr int kMost =
      6;  // shift x, y; change of x with u, v; of y with u, v [by definition]
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
