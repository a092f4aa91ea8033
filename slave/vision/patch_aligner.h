// Finds a patch of one image in another one to a small part of a pixel.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace palpate {

// Pose of a patch in an image: pixel u of the patch (from its centre) is at A u + p.
struct PatchWarp {
  Eigen::Matrix2d A = Eigen::Matrix2d::Identity();
  Eigen::Vector2d p{0, 0};  // the centre [px]; (0, 0) is the centre of the upper left pixel

  // Returns the warp of the same patch in an image that is `level` times reduced by two.
  [[nodiscard]] PatchWarp OnLevel(int level) const {
    const double scale = 1.0 / (1 << level);
    return {A, ((p.array() + 0.5) * scale - 0.5).matrix()};
  }
  [[nodiscard]] PatchWarp FromLevel(int level) const {
    const double scale = 1 << level;
    return {A, ((p.array() + 0.5) * scale - 0.5).matrix()};
  }
};

// Sum of squared differences over a shift or an affine warp, with gain a and offset b of the light:
//   sum w (I(A u + p) - a T(u) - b)^2 -> min
// by Gauss-Newton with the template's gradients (inverse compositional form: S. Baker and I.
// Matthews, IJCV 56, 2004), made orthogonal to T and 1 beforehand so that gain and offset drop out.
// Images are grey, of type CV_8UC1 or CV_16SC1. All but the constructors is real-time safe. Not
// thread-safe: it stores the interpolated pixels.
class PatchAligner {
 public:
  enum class Freedom : unsigned char { kShift, kAffine };

  struct Match {
    bool converged = false;
    PatchWarp warp;
    double correlation = -1;  // of Align: correlation of patch and image, [-1, 1]
    double covered = 0;       // of AlignRobustly: part of the patch that something hides [0, 1]
    // Covariance of warp.p, from the residual [px^2].
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  };

  // Makes a square window of texture, `edge` odd, 5 to 255 [px]; throws std::invalid_argument. Its
  // weights are a Gaussian about the centre, whose position is estimated: on a curved surface
  // distant pixels bias the solution. Patches with too little structure for a unique position are
  // rejected.
  explicit PatchAligner(int edge);
  // Makes a patch with weights 0 or 1, row by row. It needs only some structure in every direction.
  PatchAligner(const cv::Size& size, const std::vector<float>& weights);

  // Stores the patch under `warp`. Returns false and stores no patch if it (with a pixel around it,
  // for the gradients) leaves the image or has too little structure in some direction.
  bool Cut(const cv::Mat& grey, const PatchWarp& warp, Freedom freedom = Freedom::kAffine) noexcept;

  // Aligns from within a few pixels of the result.
  Match Align(const cv::Mat& grey, const PatchWarp& start, Freedom freedom) noexcept;
  // Aligns a shift of at most 3 px by iteratively reweighted squares (Tukey): changed parts, such
  // as a reflection, a wire or the edge of a shadow, are excluded. `trust`: one per pixel of the
  // patch, 0 for those excluded at first; empty: all are used.
  Match AlignRobustly(const cv::Mat& grey, const PatchWarp& start,
                      std::span<const float> trust) noexcept;
  // Correlation at one position; -1 outside the image or without contrast.
  double Score(const cv::Mat& grey, const PatchWarp& warp) noexcept;

  [[nodiscard]] int edge() const { return size_.width; }
  [[nodiscard]] bool textured() const { return textured_; }
  // Returns the Hessian of the shift without gain and offset, per squared grey level [1/px^2]:
  // white noise of sigma levels in the image moves p by sigma sqrt(H^-1).
  [[nodiscard]] const Eigen::Matrix2d& information() const { return information_; }

 private:
  static constexpr int kMaxFreedoms =
      6;  // shift x, y; change of x with u, v; of y with u, v [by definition]
  struct Sums;
  using Fit = Eigen::Vector4d;  // of the image by the gradients of the shift, T~ and 1

  void Allocate();
  bool Sample(const cv::Mat& grey, const PatchWarp& warp, int ring) noexcept;
  void FillBasis(bool affine) noexcept;
  bool Invert(int freedoms) noexcept;
  double WeighLevels() noexcept;
  Sums Project(bool affine) noexcept;
  void Update(const Eigen::Matrix<double, kMaxFreedoms, 1>& delta, PatchWarp* warp) const noexcept;
  void Conclude(const Sums& sums, bool affine, Match* match) const noexcept;
  Fit Regress(Eigen::Matrix4d* inverse) noexcept;
  void Reweigh(const Fit& fit) noexcept;
  void Assess(const Fit& fit, const Eigen::Matrix4d& inverse, Match* match) const noexcept;

  cv::Size size_;
  std::ptrdiff_t count_;
  double min_slope_ = 0;  // root mean square change by a pixel, in every direction [levels/px]
  bool textured_ = false, affine_ = false;
  float mean_ = 0;         // of the template
  double contrast_ = 0;    // sum T~^2
  Eigen::MatrixXf basis_;  // pixels x 8: gradients g' (shift, affine), T~, 1; times sqrt(w)
  Eigen::VectorXf root_weights_;
  double weight_ = 0;       // sum of the weights
  Eigen::VectorXf levels_;  // sampled levels, with a border when a template is cut
  Eigen::Matrix2d information_ = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d shift_inverse_ = Eigen::Matrix2d::Zero();
  Eigen::Matrix<double, kMaxFreedoms, kMaxFreedoms> affine_inverse_ =
      Eigen::Matrix<double, kMaxFreedoms, kMaxFreedoms>::Zero();
  // Memory of AlignRobustly: residuals, Tukey's weights and the basis times these.
  Eigen::VectorXf errors_, trust_;
  Eigen::MatrixX4f trusted_;
  std::vector<float> sizes_;
};

}  // namespace palpate
