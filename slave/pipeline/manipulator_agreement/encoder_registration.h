// Registration of the manipulator's encoders against a camera: a Kalman filter whose innovation
// compares the measured tip with the encoder pose.
#pragma once

#include <cmath>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "slave/pipeline/manipulator_agreement/arm_consistency_check.h"

namespace palpate {

//   p_seen - p = x + s (p - p_0) + lag dp + v
//
// with the encoder pose p, its change dp since the last image, the offset x of both frames, the
// scale error s of the encoders, and noise v of the image. x drifts as a random walk. Frame S;
// allocation-free.
class EncoderRegistration {
 public:
  // Adds one image [m]. `sigma`: of the measured tip, per axis. An innovation beyond the gate is
  // ignored.
  void Update(const Eigen::Vector3d& p_S_seen, const EncoderReading& encoder,
              double sigma) noexcept {
    if (!origin_) Begin(p_S_seen, encoder);
    Eigen::Matrix<double, 3, kStates> H;
    step_ = encoder.p_S_tip - last_;
    last_ = encoder.p_S_tip;
    H << Eigen::Matrix3d::Identity(), encoder.p_S_tip - *origin_, step_;
    P_.diagonal().head<3>().array() += kDrift * kDrift * sigma * sigma;
    innovation_ = p_S_seen - encoder.p_S_tip - H * x_;
    const Eigen::Matrix<double, kStates, 3> PH = P_ * H.transpose();
    const Eigen::Matrix3d S = H * PH + sigma * sigma * Eigen::Matrix3d::Identity();
    const Eigen::LLT<Eigen::Matrix3d> solver(S);
    nis_ = innovation_.dot(solver.solve(innovation_));
    sigma_ = std::sqrt(S.trace() / 3);
    if (!(nis_ < kGate)) return;
    const Eigen::Matrix<double, kStates, 3> K = solver.solve(PH.transpose()).transpose();
    x_ += K * innovation_;
    P_ -= K * PH.transpose();
  }

  // Measured minus predicted tip in the last image [m], its standard deviation per axis [m], and
  // the normalised square, chi-square with 3 degrees of freedom.
  [[nodiscard]] const Eigen::Vector3d& innovation() const { return innovation_; }
  [[nodiscard]] double sigma() const { return sigma_; }
  [[nodiscard]] double nis() const { return nis_; }
  // Deviation of the tip from the registered encoder pose in the last image, a lag included [m].
  [[nodiscard]] Eigen::Vector3d deviation() const { return innovation_ + x_(kLag) * step_; }

 private:
  static constexpr int kStates = 5, kScale = 3, kLag = 4;
  // Quantile 0.9999 of chi-square with 3 degrees of freedom [-]. [by definition]
  static constexpr double kGate = 21.1;
  // Drift of the offset per image, of the tip's sigma [-]. [tuned: late]
  static constexpr double kDrift = 0.01;
  // Scale error of encoders, prior sigma [-]. [tuned:
  // DistinguishesCameraBumpsFromObjectShifts]
  static constexpr double kScaleSigma = 0.05;
  static constexpr double kAnyOffset = 1;  // prior sigma [m]

  void Begin(const Eigen::Vector3d& p_S_seen, const EncoderReading& encoder) noexcept {
    origin_ = last_ = encoder.p_S_tip;
    x_.setZero();
    x_.head<3>() = p_S_seen - encoder.p_S_tip;
    P_.setZero();
    P_.diagonal().head<3>().setConstant(kAnyOffset * kAnyOffset);
    P_(kScale, kScale) = kScaleSigma * kScaleSigma;
    P_(kLag, kLag) = encoder.lag * encoder.lag;
  }

  std::optional<Eigen::Vector3d> origin_;  // first encoder pose
  Eigen::Vector3d last_{0, 0, 0}, step_{0, 0, 0}, innovation_{0, 0, 0};
  Eigen::Matrix<double, kStates, 1> x_ = Eigen::Matrix<double, kStates, 1>::Zero();
  Eigen::Matrix<double, kStates, kStates> P_ = Eigen::Matrix<double, kStates, kStates>::Zero();
  double sigma_ = 0, nis_ = 0;
};

}  // namespace palpate
