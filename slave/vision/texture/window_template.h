// Windows of texture: where they lie, which are worth tracking, how they find themselves in another
// picture.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace palpate {

// Where a window lies in a picture: the pixel u of the window (from its centre) is at A u + p.
struct WindowWarp {
  Eigen::Matrix2d A = Eigen::Matrix2d::Identity();
  Eigen::Vector2d p{0, 0};  // the centre [px]; (0, 0) is the centre of the upper left pixel

  // The same window on a picture shrunk by two, `level` times over.
  [[nodiscard]] WindowWarp OnLevel(int level) const {
    const double scale = 1.0 / (1 << level);
    return {A, ((p.array() + 0.5) * scale - 0.5).matrix()};
  }
  [[nodiscard]] WindowWarp FromLevel(int level) const {
    const double scale = 1 << level;
    return {A, ((p.array() + 0.5) * scale - 0.5).matrix()};
  }
};

// A grey picture and its halves, quarters, ...: what windows of texture are looked for in, coarse
// to fine.
class PicturePyramid {
 public:
  // `levels` >= 1; fewer where the picture would shrink below 32 px. Throws std::invalid_argument:
  // not 8 bit, neither grey nor BGR, smaller than 32 px.
  PicturePyramid(const cv::Mat& first, int levels);

  // Takes a picture in, of the first one's size and type; false (and nothing changed) otherwise.
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

// Windows worth tracking, where nobody named any: centres [px] of at most `count` windows of `edge`
// px whose structure tensor (sum of grad grad^T over the window) has the largest lesser
// eigenvalues: J. Shi and C. Tomasi, CVPR 1994. At least `apart` from each other and a window
// inside the picture; best first. Empty: no texture, or nothing to read (not 8 bit, neither grey
// nor BGR).
std::vector<Eigen::Vector2d> ChooseWindows(const cv::Mat& picture, int count, int edge,
                                           double apart);

// A window of texture that finds itself in another picture.
//
// Sum of squared differences over an affine warp, with gain a and offset b of the light:
//   sum w (I(A u + p) - a T(u) - b)^2 -> min
// by Gauss-Newton with the template's gradients, made orthogonal to T and 1 beforehand so that gain
// and offset drop out (inverse compositional form: S. Baker and I. Matthews, IJCV 56, 2004). Paper
// C tracks shifts only; an approaching or turning organ needs the affine part. The weights w are a
// Gaussian about the centre, whose place is asked for: where the surface bends, what lies further
// out pulls the answer away.
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
