// Two cameras before the textured target: the stated rig and camera (640 x 480, focal 800 px,
// baseline 60 mm, 250 mm away, verged on the middle of the path; blur 0.7 px, noise 2 of 255).
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
  // The body moved by p_S from its place at rest, turned about its own axes [rad].
  Pair Take(const Eigen::Vector3d& p_S, const Eigen::Vector3d& turn = {0, 0, 0});

  // Where the point of the body that the left camera sees at p_I (body at `from`) is when the body
  // is at `to`. Frame S [m].
  [[nodiscard]] Eigen::Vector3d PointOf(const Eigen::Vector2d& p_I, const Eigen::Vector3d& from,
                                        const Eigen::Vector3d& to) const;

  const StereoRig rig = VergedRig(SceneLens());
  const Eigen::Isometry3d X_SL = VergedPose(-1);

 private:
  [[nodiscard]] Eigen::Isometry3d X_SB(const Eigen::Vector3d& p_S,
                                       const Eigen::Vector3d& turn) const;
  cv::Mat Finish(const cv::Mat& canvas);

  simulation::TexturedTarget target_;
  cv::Mat noise_;  // larger than an image; each takes another part of it
  cv::RNG random_{11};
  cv::Mat canvas_, blurred_;
};

}  // namespace palpate
