// Further contents of a microscope image: the glass capillary that holds the embryo, debris that
// drifts in the liquid, and a varying focus.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/site/camera/true_body.h"

namespace palpate::site {

class Microscope {
 public:
  static constexpr double kWall = 9e-6;                     // of the capillary [m]
  static constexpr float kGlass = 0.62F;                    // light that its wall lets through
  static constexpr double kFocusPeriod = 97;                // [images]
  static constexpr double kSlowest = 0.05, kFastest = 0.5;  // of debris [px per image]

  // `X_IO`: O [m] -> image [px]. The capillary grips the arc that the scene fixes, if it does.
  Microscope(const Scene& scene, const TrueBody& body, const Eigen::Affine2d& X_IO,
             const cv::Size& size);

  // Draws glass and debris over `seen` (CV_32F, the image's size) and blurs it. Debris drifts and
  // the focus changes with each call.
  void Show(cv::Mat* seen);

 private:
  struct Particle {
    Eigen::Vector2d p_I, v_I;  // [px], [px per image]
    double radius = 0;         // [px]
    float light = 1;           // that it lets through in its middle
  };

  void PaintCapillary(const FixedArc& arc, double radius, const Eigen::Affine2d& X_IO);
  void Scatter(const EmbryoSite& options, std::uint32_t seed);
  static void Cover(const Particle& particle, cv::Mat* seen);

  cv::Size size_;
  double defocus_;
  cv::Mat glass_;  // CV_32F, light that is let through
  std::vector<Particle> debris_;
  std::uint64_t pictures_ = 0;
};

}  // namespace palpate::site
