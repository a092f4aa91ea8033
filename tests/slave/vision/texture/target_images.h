// Two cameras in front of the textured target (640 x 480, focal length 800 px, baseline 60 mm,
// distance 250 mm, verged on the centre of the path; blur 0.7 px, noise 2 of 255).
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "slave/simulator/points/textured_target.h"
#include "slave/vision/stereo/rig.h"
#include "tests/slave/vision/stereo/test_rigs.h"

namespace palpate {

class TargetImages {
 public:
  TargetImages();

  struct Pair {
    cv::Mat left, right;
  };
  // Draws both images of the body, displaced by p_S from its rest position and rotated about its
  // own axes [rad].
  Pair Take(const Eigen::Vector3d& p_S, const Eigen::Vector3d& turn = {0, 0, 0});

  // Returns the position, with the body at `to`, of the body point that the left camera sees at p_I
  // with the body at `from`. Frame S [m].
  [[nodiscard]] Eigen::Vector3d PointOf(const Eigen::Vector2d& p_I, const Eigen::Vector3d& from,
                                        const Eigen::Vector3d& to) const;

  const StereoRig rig = VergedRig(SceneLens());
  const Eigen::Isometry3d X_SL = VergedPose(-1);

 private:
  [[nodiscard]] Eigen::Isometry3d X_SB(const Eigen::Vector3d& p_S,
                                       const Eigen::Vector3d& turn) const;
  cv::Mat Finish(const cv::Mat& canvas);

  simulation::TexturedTarget target_;
  cv::Mat noise_;  // larger than an image; each image uses another part of it
  cv::RNG random_{11};
  cv::Mat canvas_, blurred_;
};

}  // namespace palpate
