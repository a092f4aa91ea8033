// Whether one camera and the manipulator's encoders agree on the tip, and whose motion an image
// shows.
#pragma once

#include <Eigen/Core>

#include "shared/state/clock.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/manipulator_agreement/arm_consistency_check.h"
#include "slave/pipeline/manipulator_agreement/moving_object.h"

namespace palpate {

// Allocation-free. Frame S.
class ManipulatorAgreement {
 public:
  struct Sight {
    Time at{};
    Eigen::Vector3d p_S_seen{0, 0, 0};       // tip in the image [m]
    Eigen::Vector3d p_S_at_rest{0, 0, 0};    // relative to an object at rest, for the estimate [m]
    double sigma = 0;                        // of both [m]
    bool object_known = false;               // the image shows the object
    Eigen::Vector3d p_S_on_object{0, 0, 0};  // as seen, relative to an object at rest [m]
    double object_sigma = 0;                 // of the object's motion [m]
    double pixel = 0;                        // [m]
  };

  // One image. Where the camera moved the image agrees with the encoders relative to the object,
  // where the object moved it agrees as it is: one of both is enough.
  void Update(const Sight& sight, const EncoderReading& reading) noexcept {
    const double tolerance = kApart * sight.pixel + kSigmas * sight.sigma;
    const bool in_image = in_image_.Agree(sight.p_S_seen, reading, tolerance);
    const bool on_object = on_object_.Agree(sight.p_S_at_rest, reading, tolerance);
    agrees_ = in_image || on_object;
    parting_.setZero();
    if (reading.is_of_picture) {  // else ImageLatencyEstimator knows better
      const Eigen::Vector3d a = in_image_.PartingBeyond(kNoiseSigmas * sight.sigma);
      const Eigen::Vector3d b = on_object_.PartingBeyond(kNoiseSigmas * sight.sigma);
      parting_ = a.norm() < b.norm() ? a : b;
    }
    if (!sight.object_known) return;
    object_.Update(sight.at, sight.p_S_seen, sight.p_S_on_object, sight.object_sigma,
                   kStill * sight.pixel, reading);
  }
  // No encoder reading belongs to this image.
  void Skip() noexcept { agrees_ = true, parting_.setZero(); }

  [[nodiscard]] bool agrees() const { return agrees_; }
  // Unexplained difference of image and encoders, S [m].
  [[nodiscard]] const Eigen::Vector3d& parting() const { return parting_; }
  [[nodiscard]] const SurfaceMotion& motion() const { return object_.motion(); }
  void Reset() noexcept { *this = {}; }

  // Distance of the tip from the encoder reading, after the start [px]. [tuned: late]
  static constexpr double kApart = 0.3;

 private:
  // The same by its sigma [-].
  static constexpr double kSigmas = 3;
  // Difference that is noise of the image alone [sigma].
  static constexpr double kNoiseSigmas = 2;
  // Difference that is no motion [px].
  static constexpr double kStill = 1;

  ArmConsistencyCheck in_image_, on_object_;
  MovingObject object_;
  Eigen::Vector3d parting_{0, 0, 0};
  bool agrees_ = true;
};

}  // namespace palpate
