// Checks whether a stereo pair sees the same points at the same time. If the two rays of a point
// miss each other by more than the noise, one camera has moved, the rig is wrong, or the images
// were taken at different times. The check needs only the images and is independent of the load on
// the object.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "slave/checks/check.h"
#include "slave/checks/points/points_limits.h"
#include "slave/checks/points/points_sample.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

// The check subtracts the baseline of each point from its miss. It explains the remainder by
//
//   miss = c0 + c1 x + c2 y + c3 x y + tau (v(t) - v(t - k)) + noise,   x, y: place in the image
//
// The first four terms model a camera that has moved. The last one models a right image that is
// late (tau > 0) or early: v is the position of a point across its epipolar line, and k is one to
// six images, or the time since the baseline (a frozen camera).
//
// Motions and delays along the epipolar lines are not detected. Used by one thread; allocation-free
// after the first pair with as many points.
class EpipolarCheck final : public Check<PointsSample> {
 public:
  // `rest_images`: number of images whose mean is the baseline of a point, >= 1. `sigma_px`:
  // smallest sigma of the points' covariances. `max_at_rest`: of a correct rig, in addition to its
  // own rms [px].
  EpipolarCheck(const StereoRig& rig, int rest_images, double sigma_px,
                double max_at_rest = PointsLimits::kMaxAtRest)
      : rig_(rig), rest_images_(rest_images), sigma_px_(sigma_px), max_at_rest_(max_at_rest) {}

  // Sets the uncertainty of the time (sensed_at, skew), and whether the points have only noise;
  // widens their covariances if the ray distances scatter by more than the image noise.
  void Examine(const PointsSample& sample, Findings* findings) noexcept override;
  void Reset() noexcept override { rows_.clear(); }

 private:
  // Lags [image periods] and unknowns of a motion [-]. [by definition]
  static constexpr int kLags = 6, kMotions = 4;
  struct Row {  // of a point
    double rest_miss = 0, rest_square = 0, rest_place = 0;
    int rest_count = 0;
    std::array<double, kLags + 1> places{};  // across the epipolar line, a ring buffer [px]
    std::array<bool, kLags + 1> seen{};
    Eigen::Vector4d motions{0, 0, 0, 0};  // divided by sigma
    double miss = 0, sigma = 1;           // less that at rest; expected [px]
    bool counts = false, kept = false;
  };
  struct Evidence {  // of one lag: its normal equation, divided by sigma
    double motion = 0, product = 0;
  };
  // Delay of the right image beyond its timestamp, as weighted mean per pair [pair periods].
  struct Stamps {
    double weight = 0, late = 0, square = 0, weights = 0, pairs = 0;
    void Learn(double motion, double product) noexcept;
    [[nodiscard]] bool AreWrong() const noexcept;
    // Returns the sigma of one pair, including the information of the others.
    [[nodiscard]] double Sigma() const noexcept;
  };
  using Matrix4 = Eigen::Matrix<double, kMotions, kMotions>;

  void Read(const SurfacePoint& point, bool is_baseline, Row* row) noexcept;
  [[nodiscard]] double PositionAcross(const Row& row, int lag) const noexcept;
  bool ExplainByMotion() noexcept;
  void DropOutliers() noexcept;
  [[nodiscard]] double Residual(const Row& row) const noexcept {
    return row.miss / row.sigma - row.motions.dot(motion_);
  }
  bool IsOfAnotherInstant(int lag) noexcept;
  void CheckRest(const SurfaceObservation& seen, Findings* findings) const noexcept;
  void CheckPair(SurfaceObservation* seen, Findings* findings) noexcept;

  StereoRig rig_;
  int rest_images_;
  double sigma_px_, max_at_rest_;
  int taken_ = 0;   // images of rest_images_ that were used
  int newest_ = 0;  // index in the ring buffers
  std::vector<Row> rows_;
  std::array<Evidence, kLags + 1> evidence_{};
  Stamps stamps_;
  double reported_late_ = 0;  // the right image by its timestamp [pair periods]
  Time newest_at_{};
  std::vector<double> sorted_;
  Matrix4 normal_ = Matrix4::Identity();
  Eigen::Vector4d motion_{0, 0, 0, 0};  // explained part of the ray distances [px]
  int count_ = 0;                       // for the remaining points
  double scatter_ = 1;                  // scatter of residuals / sigma
  // Scatter of a point's ray distance at rest for its image noise; infinite: unknown.
  double scatter_at_rest_ = std::numeric_limits<double>::infinity();
  double noise_at_rest_ = 1;  // smallest scatter to use, relative to the reported noise
};

}  // namespace palpate
