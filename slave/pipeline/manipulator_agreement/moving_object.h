// Motion of the object since the first image, if the encoders distinguish it from camera motion.
#pragma once

#include <Eigen/Core>

#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/manipulator_agreement/arm_consistency_check.h"
#include "slave/pipeline/manipulator_agreement/motion_disambiguator.h"
#include "slave/pipeline/manipulator_agreement/motion_trend.h"

namespace palpate {

// Allocation-free. Frame S.
class MovingObject {
 public:
  // For one image [m]: the measured tip, and the tip relative to an object at rest; sigma of the
  // motion between both; `still`: smallest motion.
  void Update(Time at, const Eigen::Vector3d& p_S_seen, const Eigen::Vector3d& p_S_on_object,
              double sigma, double still, const EncoderReading& said) noexcept {
    owner_.Update(p_S_seen, p_S_on_object, said, still);
    motion_ = {};
    if (owner_.is_objects()) motion_.offset = p_S_seen - p_S_on_object;
    trend_.Add(at, motion_.offset, sigma);
    motion_.velocity = trend_.velocity();
    motion_.velocity_error = trend_.error();
  }
  // Zero if the camera moves, or if the tool position is unknown.
  [[nodiscard]] const SurfaceMotion& motion() const noexcept { return motion_; }
  void Reset() noexcept { *this = {}; }

 private:
  MotionDisambiguator owner_;
  MotionTrend trend_;
  SurfaceMotion motion_;
};

}  // namespace palpate
