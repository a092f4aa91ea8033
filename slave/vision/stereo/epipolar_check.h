// Whether two eyes see the same points at the same instant: where a point's two rays pass each
// other by more than its noise, one camera has moved against the other, the rig is not theirs, or
// their pictures are of different instants. Nothing else than the pictures is needed for it, and no
// load on the object changes it.
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
//   miss = c0 + c1 x + c2 y + c3 x y + tau (v(t) - v(t - k)) + noise,   x, y: place in the picture
//
// the first four being a camera that has moved, the last one a right picture that is late (tau > 0)
// or early: v is where the points are across their epipolar lines, k one to six pictures, or since
// rest, which is a camera that stands still.
//
// Not seen by it: a camera that moved or a picture that is late along the epipolar lines only. One
// thread; allocation-free after the first pair with as many points.
class EpipolarCheck {
 public:
  static constexpr double kMostOffset = 0.5;  // of a camera that has not moved [px]
  static constexpr double kMostAtRest = 0.5;  // of a rig that is theirs, beside its own rms [px]
  static constexpr double kMostLag = 0.2;     // [periods]

  // `rest_pictures`: whose mean is what a point has at rest, >= 1. `sigma_px`: the least that the
  // points' covariances were made with. `most_at_rest`: kMostAtRest, less of a rig known better.
  EpipolarCheck(const StereoRig& rig, int rest_pictures, double sigma_px,
                double most_at_rest = kMostAtRest)
      : rig_(rig),
        rest_pictures_(rest_pictures),
        sigma_px_(sigma_px),
        most_at_rest_(most_at_rest) {}

  // Puts its doubt into `seen`, how well the moment is known that its stamps tell (sensed_at,
  // skew), whether its points err by noise alone, and widens their covariances where the misses
  // scatter by more than the pictures' noise says.
  void Process(SurfaceObservation* seen) noexcept;
  void Reset() { rows_.clear(); }

  // Of the last pair, rms over its points: what a camera's motion explains, and the scatter of one
  // point's place, per axis [px].
  [[nodiscard]] double offset_px() const { return offset_px_; }
  [[nodiscard]] double noise_px() const { return noise_px_; }

 private:
  static constexpr int kLags = 6, kMotions = 4;
  struct Row {  // of a point
    double rest_miss = 0, rest_square = 0, rest_place = 0;
    int rest_count = 0;
    std::array<double, kLags + 1> places{};  // across the epipolar line, a ring [px]
    std::array<bool, kLags + 1> seen{};
    Eigen::Vector4d motions{0, 0, 0, 0};  // by sigma
    double miss = 0, sigma = 1;           // less that at rest; expected [px]
    bool counts = false, kept = false;
  };
  struct Evidence {  // of one lag: its normal equation, by sigma
    double motion = 0, product = 0;
  };
  // How late the right picture is beyond what its stamp tells, of each pair by weighted mean [times
  // from pair to pair].
  struct Stamps {
    double weight = 0, late = 0, square = 0, weights = 0, pairs = 0;
    void Learn(double motion, double product) noexcept;
    [[nodiscard]] bool AreWrong() const noexcept;
    // Of one pair, what is known of the others included.
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
  int newest_ = 0;  // place in the rings
  std::vector<Row> rows_;
  std::array<Evidence, kLags + 1> evidence_{};
  Stamps stamps_;
  double told_late_ = 0;  // the right picture, by its stamp [times from pair to pair]
  Time newest_at_{};
  std::vector<double> sorted_;
  Matrix4 normal_ = Matrix4::Identity();
  Eigen::Vector4d motion_{0, 0, 0, 0};  // what explains the misses [px]
  int count_ = 0;                       // of the points that are kept
  double scatter_ = 1;                  // of the residuals by sigma
  // Scatter of a point's miss at rest by what its picture says; infinite: unknown.
  double scatter_at_rest_ = std::numeric_limits<double>::infinity();
  double noise_at_rest_ = 1;  // likewise, the least to count with
  double offset_px_ = 0, noise_px_ = 0;
};

}  // namespace palpate
