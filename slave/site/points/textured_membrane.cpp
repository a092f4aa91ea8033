#include "slave/site/points/textured_membrane.h"

#include <cmath>
#include <cstddef>
#include <optional>

namespace palpate::site {
namespace {

using Eigen::Vector2d;

constexpr int kCells = 72;  // across the membrane
constexpr double kTexelsPerGrain = 5;
constexpr float kGrey = 120, kContrast = 90;

}  // namespace

TexturedMembrane::TexturedMembrane(const MembraneView& view, std::uint32_t seed,
                                   const Exposure& exposure)
    : view_(view),
      exposure_(exposure),
      texture_(Texture::Speckle(seed + 7, kTexelsPerGrain, kGrey, kContrast)),
      ground_(view.PlainFace()) {
  LayGrid();
}

// A square grid, mapped onto the disc so that its edge becomes the rim: rings of the square become
// circles (Shirley and Chiu 1997, without their equal areas).
void TexturedMembrane::LayGrid() {
  const double texels = kGrains * kTexelsPerGrain / (2 * view_.radius);  // per metre
  for (int j = 0; j <= kCells; ++j) {
    for (int i = 0; i <= kCells; ++i) {
      const Vector2d square(2.0 * i / kCells - 1, 2.0 * j / kCells - 1);
      const double ring = square.cwiseAbs().maxCoeff();
      const Vector2d disc = ring > 0 ? Vector2d(ring * square.normalized()) : Vector2d(0, 0);
      nodes_O_.push_back(view_.radius * disc);
      on_texture_.push_back(texels * nodes_O_.back());
    }
  }
  const auto node = [](int i, int j) { return j * (kCells + 1) + i; };
  for (int j = 0; j < kCells; ++j) {
    for (int i = 0; i < kCells; ++i) {
      triangles_.push_back({node(i, j), node(i + 1, j), node(i + 1, j + 1)});
      triangles_.push_back({node(i, j), node(i + 1, j + 1), node(i, j + 1)});
    }
  }
}

const cv::Mat& TexturedMembrane::Paint(const Dent& dent) {
  ground_.copyTo(seen_);
  std::vector<std::optional<Vector2d>> p_I;
  p_I.reserve(nodes_O_.size());
  for (const Vector2d& p_O : nodes_O_)
    p_I.push_back(Project(view_.lens, view_.X_CO * view_.Place(p_O, dent)));
  for (const auto& [i, j, k] : triangles_) {
    const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
    const auto c = static_cast<std::size_t>(k);
    if (!p_I[a] || !p_I[b] || !p_I[c]) continue;
    texture_.Fill(seen_, {0, 0}, {*p_I[a], *p_I[b], *p_I[c]},
                  {on_texture_[a], on_texture_[b], on_texture_[c]});
  }
  exposure_.Blur(seen_);
  return seen_;
}

}  // namespace palpate::site
