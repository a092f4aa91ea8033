// Compares the tip in one camera with the manipulator's encoders, and distinguishes motion of the
// camera from motion of the object.
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "shared/state/clock.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/manipulator_agreement/encoder_registration.h"
#include "slave/pipeline/manipulator_agreement/motion_trend.h"

namespace palpate {

// Two hypotheses, each with a registration of the encoders. If the camera moved, the tip relative
// to the object agrees with them; if the object moved, the tip in the image does. A sequential
// probability ratio test (Wald, 1945) decides between both. Allocation-free. Frame S.
class ManipulatorAgreement {
 public:
  struct Sight {
    Time at{};
    Eigen::Vector3d p_S_seen{0, 0, 0};       // tip in the image [m]
    Eigen::Vector3d p_S_at_rest{0, 0, 0};    // the same relative to the object at rest [m]
    double sigma = 0;                        // of both, per axis [m]
    Eigen::Vector3d p_S_on_object{0, 0, 0};  // measured tip relative to the object at rest [m]
    bool object_known = false;               // the image shows the object
    double object_sigma = 0;                 // of the object's motion [m]
    double pixel = 0;                        // [m]
  };

  // Adds one image.
  void Update(const Sight& sight, const EncoderReading& reading) noexcept {
    const double sigma = std::hypot(sight.sigma, kTipSigma * sight.pixel);
    has_reading_ = true;
    sigma_ = sight.sigma;
    if_object_moves_.Update(sight.p_S_seen, reading, sigma);
    if_camera_moves_.Update(sight.p_S_at_rest, reading, sigma);
    if (!sight.object_known) return;
    const double ratio = 0.5 * (if_camera_moves_.nis() - if_object_moves_.nis());
    evidence_ += std::clamp(ratio, -kMaxPerImage, kMaxPerImage);
    evidence_ = std::clamp(evidence_, -kDecisionRatio, kDecisionRatio);
    if (evidence_ >= kDecisionRatio) object_moves_ = true;
    if (evidence_ <= -kDecisionRatio) object_moves_ = false;
    FollowObject(sight);
  }
  // Adds an image without an encoder reading. The decision stays as it was.
  void Skip(const Sight& sight) noexcept {
    has_reading_ = false;
    if (sight.object_known) FollowObject(sight);
  }
  // Adds an image in which the tip is lost.
  void Skip() noexcept { has_reading_ = false; }

  [[nodiscard]] bool has_reading() const { return has_reading_; }
  // The registration of the hypothesis that explains the last image better.
  [[nodiscard]] const EncoderRegistration& registration() const {
    const bool object = if_object_moves_.nis() < if_camera_moves_.nis();
    return object ? if_object_moves_ : if_camera_moves_;
  }
  // Deviation of the tip from the encoders that its noise does not explain, S [m].
  [[nodiscard]] Eigen::Vector3d Unexplained() const noexcept {
    Eigen::Vector3d unexplained = Eigen::Vector3d::Zero();
    if (!has_reading_) return unexplained;
    const Eigen::Vector3d deviation = registration().deviation();
    const double noise = kNoiseSigmas * sigma_, size = deviation.norm();
    if (size > noise) unexplained = (1 - noise / size) * deviation;
    return unexplained;
  }
  // Returns the motion of the object; zero if the camera moves or it is undecided.
  [[nodiscard]] const SurfaceMotion& motion() const { return motion_; }
  void Reset() noexcept { *this = {}; }
  // Restarts the registrations after a change of the encoders' origin.
  void ForgetEncoders() noexcept { if_object_moves_ = if_camera_moves_ = {}; }

  // Error of the tip that its tracker does not report [px]. [tuned: late]
  static constexpr double kTipSigma = 0.1;

 private:
  // Log-likelihood ratio at which a hypothesis is accepted: ln 10^4 [-]. [by definition]
  static constexpr double kDecisionRatio = 9.2;
  // Largest part of it that one image contributes: three images must agree [-]. [tuned:
  // DistinguishesCameraBumpsFromObjectShifts]
  static constexpr double kMaxPerImage = kDecisionRatio / 3;

  // Largest deviation that image noise explains [sigma]. [tuned: late]
  static constexpr double kNoiseSigmas = 2;

  void FollowObject(const Sight& sight) noexcept {
    motion_ = {};
    if (object_moves_) motion_.offset = sight.p_S_seen - sight.p_S_on_object;
    trend_.Add(sight.at, motion_.offset, sight.object_sigma);
    motion_.velocity = trend_.velocity();
    motion_.velocity_error = trend_.error();
  }

  EncoderRegistration if_object_moves_, if_camera_moves_;
  double sigma_ = 0;     // of the last image's tip [m]
  double evidence_ = 0;  // log-likelihood ratio, > 0: the object moves
  bool object_moves_ = false, has_reading_ = false;
  MotionTrend trend_;
  SurfaceMotion motion_;
};

}  // namespace palpate
