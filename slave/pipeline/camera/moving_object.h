// The object's own motion since the first picture, where the manipulator's word tells it from the
// camera's.
#pragma once

#include <Eigen/Core>

#include "slave/pipeline/arm_consistency_check.h"
#include "slave/pipeline/camera/motion_disambiguator.h"
#include "slave/pipeline/camera/motion_trend.h"
#include "slave/pipeline/sensing_pipeline.h"

namespace palpate {

// Allocation-free. Frame S.
class MovingObject {
 public:
  // Of one picture [m]: where the tip is seen, and where it is on an object that rests; how well
  // the motion between both is known, one standard deviation; `still`: what is no motion.
  void Update(Time at, const Eigen::Vector3d& p_S_seen, const Eigen::Vector3d& p_S_on_object,
              double sigma, double still, const EncoderReading& said) noexcept {
    owner_.Update(p_S_seen, p_S_on_object, said, still);
    motion_ = {};
    if (owner_.is_objects()) motion_.offset = p_S_seen - p_S_on_object;
    trend_.Add(at, motion_.offset, sigma);
    motion_.velocity = trend_.velocity();
    motion_.velocity_error = trend_.error();
  }
  // None where what moves is the camera, or where nobody says where the tool is.
  [[nodiscard]] const SurfaceMotion& motion() const noexcept { return motion_; }
  void Reset() noexcept { *this = {}; }

 private:
  MotionDisambiguator owner_;
  MotionTrend trend_;
  SurfaceMotion motion_;
};

}  // namespace palpate
