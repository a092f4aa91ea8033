// Checks whether a stereo pair sees the same points at the same time. If a point's two rays miss
// each other by more than its noise, one camera has moved, the rig is wrong, or the images are of
// different times. The check needs only the images and is independent of the load on the object.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "slave/vision/stereo/rig.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// Of each pair's misses, what every point has had at rest is taken off; what is left is explained
// by
//
//   miss = c0 + c1 x + c2 y + c3 x y + tau (v(t) - v(t - k)) + noise,   x, y: place in the image
//
// the first four being a camera that has moved, the last one a right image that is late (tau > 0)
// or early: v is where the points are across their epipolar lines, k one to six images, or since
// rest, which is a camera that stands still.
//
// Not seen by it: a camera that moved or an image that is late along the epipolar lines only. One
// thread; allocation-free after the first pair with as many points.
class EpipolarCheck {
 public:
  static constexpr double kMostOffset = 0.5;  // of a camera that has not moved [px]
  static constexpr double kMostAtRest = 0.5;  // for a correct rig, in addition to its own rms [px]
  static constexpr double kMostLag = 0.2;     // [periods]

  // `rest_pictures`: number whose mean defines the rest of a point, >= 1. `sigma_px`: least sigma
  // of the points' covariances. `most_at_rest`: kMostAtRest, less for a rig that is known better.
  EpipolarCheck(const StereoRig& rig, int rest_pictures, double sigma_px,
                double most_at_rest = kMostAtRest)
      : rig_(rig),
        rest_pictures_(rest_pictures),
        sigma_px_(sigma_px),
        most_at_rest_(most_at_rest) {}

  // Adds to `seen` its flag, the uncertainty of the time (sensed_at, skew), and whether its points
  // have only noise; widens their covariances if the ray distances scatter by more than the image
  // noise.
  void Process(SurfaceObservation* seen) noexcept;
  void Reset() { rows_.clear(); }

  // For the last pair, rms over its points: the part that camera motion explains, and the scatter
  // of one point's position, per axis [px].
  [[nodiscard]] double offset_px() const { return offset_px_; }
  [[nodiscard]] double noise_px() const { return noise_px_; }

 private:
  static constexpr int kLags = 6, kMotions = 4;
  struct Row {  // of a point
    double rest_miss = 0, rest_square = 0, rest_place = 0;
    int rest_count = 0;
    std::array<double, kLags + 1> places{};  // across the epipolar line, a ring buffer [px]
    std::array<bool, kLags + 1> seen{};
    Eigen::Vector4d motions{0, 0, 0, 0};  // by sigma
    double miss = 0, sigma = 1;           // less that at rest; expected [px]
    bool counts = false, kept = false;
  };
  struct Evidence {  // of one lag: its normal equation, by sigma
    double motion = 0, product = 0;
  };
  // Delay of the right image beyond its timestamp, as weighted mean per pair [pair periods].
  struct Stamps {
    double weight = 0, late = 0, square = 0, weights = 0, pairs = 0;
    void Learn(double motion, double product) noexcept;
    [[nodiscard]] bool AreWrong() const noexcept;
    // For one pair, including the information of the others.
    [[nodiscard]] double Sigma() const noexcept;
  };
  using Matrix4 = Eigen::Matrix<double, kMotions, kMotions>;

  void Read(const SurfacePoint& point, bool takes_rest, Row* row) noexcept;
  [[nodiscard]] double Place(const Row& row, int lag) const noexcept;
  bool ExplainByMotion() noexcept;
  void Sift() noexcept;
  [[nodiscard]] double Residual(const Row& row) const noexcept {
    return row.miss / row.sigma - row.motions.dot(motion_);
  }
  bool IsOfAnotherInstant(int lag) noexcept;
  void CheckRest(SurfaceObservation* seen) const noexcept;
  void CheckPair(SurfaceObservation* seen) noexcept;

  StereoRig rig_;
  int rest_pictures_;
  double sigma_px_, most_at_rest_;
  int taken_ = 0;   // of them
  int newest_ = 0;  // index in the ring buffers
  std::vector<Row> rows_;
  std::array<Evidence, kLags + 1> evidence_{};
  Stamps stamps_;
  double told_late_ = 0;  // the right image by its timestamp [pair periods]
  Time newest_at_{};
  std::vector<double> sorted_;
  Matrix4 normal_ = Matrix4::Identity();
  Eigen::Vector4d motion_{0, 0, 0, 0};  // explained part of the ray distances [px]
  int count_ = 0;                       // for the remaining points
  double scatter_ = 1;                  // of the residuals by sigma
  // Scatter of a point's ray distance at rest for its image noise; infinite: unknown.
  double scatter_at_rest_ = std::numeric_limits<double>::infinity();
  double noise_at_rest_ = 1;  // least scatter to use
  double offset_px_ = 0, noise_px_ = 0;
};

}  // namespace palpate
