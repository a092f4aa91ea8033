// A fine texture printed on the inner face of a membrane, as one camera sees it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/site/exposure.h"
#include "slave/site/points/membrane_view.h"
#include "slave/site/texture.h"

namespace palpate::site {

class TexturedMembrane {
 public:
  static constexpr double kGrains = 65;  // of the texture across the membrane: 1.2 mm of 78

  // `exposure` must outlive this.
  TexturedMembrane(const MembraneView& view, std::uint32_t seed, const Exposure& exposure);
  // As DottedMembrane's. The face is drawn in facets, finest in the middle between centre and rim.
  const cv::Mat& Paint(const Dent& dent);

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

}  // namespace palpate::site
