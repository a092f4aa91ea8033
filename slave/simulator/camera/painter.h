// Renders the simulated camera image: a bright plain background, the textured deformed body, the
// dark marked tool in front; then the camera's lens, light, blur and noise. Linear in grey up to
// the last rounding.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "slave/reference/planar/patch_solution.h"
#include "slave/reference/planar/true_body.h"
#include "slave/scene/scene.h"
#include "slave/simulator/camera/hand.h"
#include "slave/simulator/environment/painting.h"
#include "slave/vision/stereo/lens_warp.h"

namespace palpate::simulation {

// Further contents of a microscope image: the glass capillary that holds the embryo, debris that
// drifts in the liquid, and a varying focus.
class Microscope {
 public:
  static constexpr double kWall = 9e-6;       // of the capillary [m]
  static constexpr float kGlass = 0.62F;      // share of the light that the wall transmits
  static constexpr double kFocusPeriod = 97;  // [images]
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
    float light = 1;           // share of the light that it transmits at its centre
  };

  void PaintCapillary(const FixedArc& arc, double radius, const Eigen::Affine2d& X_IO);
  void Scatter(const EmbryoSite& options, std::uint32_t seed);
  static void Cover(const Particle& particle, cv::Mat* seen);

  cv::Size size_;
  double defocus_;
  cv::Mat glass_;  // CV_32F, transmitted share of the light
  std::vector<Particle> debris_;
  std::uint64_t images_ = 0;
};

// Contents of the image. Frame O [m].
struct Pose {
  Eigen::Vector2d p_O_tip{0, 0};
  std::shared_ptr<const PatchSolution> contact;  // nullptr: the body rests
  Eigen::Vector2d displacement_O{0, 0};          // of the patch
  double tilt = 0;                               // of the tool, counter-clockwise [rad]
  double turn = 0;                               // of the contact, see Touched [rad]
  double t = 0;                                  // since the start [s]
};

class Painter {
 public:
  static constexpr float kGround = 200, kBody = 110, kBodyContrast = 15;  // grey levels
  static constexpr float kSides = 185;  // of a thick body, lit from above
  static constexpr float kToolDark = 25, kToolLight = 75;

  // `body` must outlive this. Throws std::invalid_argument naming the key: a lens of another size;
  // std::runtime_error: its file cannot be read.
  Painter(const Scene& scene, const TrueBody& body);

  // 8 bit grey. The same sequence of calls gives the same images. One thread at a time.
  cv::Mat Paint(const Pose& pose);

 private:
  // A part of the image: grey where `alpha` (0 to 1, coverage) is the opacity.
  struct Layer {
    Layer() = default;
    // The area inside the polygons, in one grey level.
    Layer(const cv::Rect& part, const std::vector<std::vector<Eigen::Vector2d>>& polygons,
          float level);
    cv::Rect window;
    cv::Mat grey, alpha;  // CV_32F, the window's size
  };

  [[nodiscard]] std::vector<Eigen::Vector2d> NodesOf(const Pose& pose) const;
  void PaintBody(const Pose& pose);
  void PaintSides(const Scene& scene);
  [[nodiscard]] cv::Mat Join(const Layer& tool) const;
  void FillMesh(const QuadraticMesh& mesh, const std::vector<Eigen::Vector2d>& at);
  void PaintTool(const Pose& pose);
  template <typename OnTexture>
  void FillQuad(const Texture& texture, const std::array<Eigen::Vector2d, 4>& corners,
                const Eigen::Affine2d& X_IO, const OnTexture& on_texture, Layer* layer) const;

  const TrueBody& true_body_;
  cv::Size size_;
  double pixel_;            // [m]
  Eigen::Affine2d X_IO_;    // O [m] -> image [px]
  Eigen::Affine2d X_IT_;    // O [m] -> image [px], for the plane of the tool's front side
  double tool_width_;       // [m]
  double tool_radius_;      // of its end; 0: flat [m]
  Eigen::Vector2d tool_O_;  // along which the tool points
  Texture speckle_, marks_;
  Exposure exposure_;
  std::optional<Hand> hand_;

  Layer body_, tool_;
  cv::Mat ground_;      // CV_32F: background of the front face of a thick body; empty: kGround
  cv::Mat body_alone_;  // CV_32F: the image without the tool
  Pose painted_;        // the pose that body_ shows
  std::optional<Microscope> microscope_;
  std::optional<LensWarp> lens_;
};

}  // namespace palpate::simulation
