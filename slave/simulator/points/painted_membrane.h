// The inner face of a membrane before one camera, with dots or a texture on it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/reference/membrane/pressed_membrane.h"
#include "slave/scene/scene.h"
#include "slave/simulator/environment/painting.h"
#include "slave/vision/stereo/rig.h"

namespace palpate::simulation {

// The inner face of a membrane before one camera.
struct MembraneView {
  // Grey levels: the clamp, the rubber.
  static constexpr float kBeyond = 150, kRubber = 190;

  Lens lens;
  Eigen::Isometry3d X_CO = Eigen::Isometry3d::Identity();  // p_C = X_CO p_O
  double radius = 0, thickness = 0;                        // [m]

  // Returns the present position of the inner face's point that rests at p_O [m], frame O [m].
  [[nodiscard]] Eigen::Vector3d Place(const Eigen::Vector2d& p_O,
                                      const Indentation& indentation) const;
  // Returns the image of plain rubber within the clamp, CV_32F of the lens's size, with the exact
  // coverage of each pixel.
  [[nodiscard]] cv::Mat PlainFace() const;
};

// Dark dots on the inner face of a membrane, for one camera. Frame O.
struct PrintedDots {
  std::vector<Eigen::Vector2d> places_O;  // at rest [m]
  double radius = 0;                      // [m]
};
PrintedDots DotsOn(const PointTracking& points);

class DottedMembrane {
 public:
  static constexpr float kDot = 45;  // grey level

  // `exposure` must outlive this.
  DottedMembrane(const MembraneView& view, const PrintedDots& dots, const Exposure& exposure);
  // The blurred image: CV_32F of the lens's size, valid until the next call. Dots are small stiff
  // discs: each moves with the membrane's point at its centre and tilts with the surface there; the
  // coverage of each pixel is exact. (Ink that bends with the rubber would show the mean of the
  // surface under it: 0.2 mm less than the point at the dot's centre below a tool as wide as the
  // dots, 5 mm deep; elsewhere hundredths of a millimetre.)
  const cv::Mat& Paint(const Indentation& indentation);

 private:
  // Corners of the outline of the disc at p_O in the image [px]; false: not all are visible.
  bool Outline(const Eigen::Vector2d& p_O, const Indentation& indentation,
               std::vector<Eigen::Vector2d>* outline) const;

  MembraneView view_;
  PrintedDots dots_;
  const Exposure& exposure_;
  cv::Mat ground_;  // CV_32F: blurred, without dots
  cv::Mat seen_;    // CV_32F
};

// A fine texture printed on the inner face of a membrane, for one camera.
class TexturedMembrane {
 public:
  // Number of grains across the membrane, which makes 1.2 mm per grain of 78 mm.
  static constexpr double kGrains = 65;

  // `exposure` must outlive this.
  TexturedMembrane(const MembraneView& view, std::uint32_t seed, const Exposure& exposure);
  // Paints like DottedMembrane::Paint. The face consists of facets, which are finest halfway
  // between centre and rim.
  const cv::Mat& Paint(const Indentation& indentation);

 private:
  void LayGrid();

  MembraneView view_;
  const Exposure& exposure_;
  Texture texture_;
  std::vector<Eigen::Vector2d> nodes_O_;     // at rest [m]
  std::vector<Eigen::Vector2d> on_texture_;  // [texels]
  std::vector<std::array<int, 3>> triangles_;
  cv::Mat ground_, seen_;  // CV_32F
};

}  // namespace palpate::simulation
