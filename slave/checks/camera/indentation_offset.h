// Distinguishes an offset of the depth from an indentation that is larger than computed.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Core>
#include <Eigen/LU>

namespace palpate {

// The indentation of one contact, along the normal [px]: the indentation seen at the object's edge
// compared with the one that the model computes for the tip's depth.
//
//   shown_k = (1 + f) depth_k - offset + e_k,   where that is above zero
//
// f is the model's error, constant during the contact, with a known sigma. `offset` is the apparent
// depth at the first touch: it is not zero if the tool's end or the surface is not where the scene
// states. Both are fitted by least squares. The errors e at nearly equal depths are correlated, so
// all images within one pixel of depth count as one. Images without an indentation are not used.
// Used by one thread. Allocation-free.
class IndentationOffset {
 public:
  struct Image {
    double depth = 0;  // computed, > 0 [px]
    double shown = 0;  // from the detected edge [px]
    double sigma = 0;  // of their difference, > 0 [px]
  };
  // `model`: sigma of f [-]. `edge`: sigma of the common error of all images at one depth [px].
  void Add(const Image& image, double model, double edge) noexcept {
    const auto index = static_cast<std::size_t>(std::max(image.depth, 0.0));
    const bool shows = image.shown > kShows * std::hypot(image.sigma, edge);
    if (!(image.depth > 0) || !shows || index >= bins_.size()) return;
    Bin& bin = bins_[index];
    ++bin.count;
    const double share = 1.0 / bin.count;
    bin.depth += share * (image.depth - bin.depth);
    bin.value += share * (image.shown - image.depth - bin.value);
    bin.variance += share * (image.sigma * image.sigma - bin.variance);
    Fit(model, edge);
  }
  // The offset [px], and its sigma [px]; no image yet: 0, and infinite.
  [[nodiscard]] double value() const { return value_; }
  [[nodiscard]] double sigma() const { return sigma_; }
  void Reset() noexcept { *this = {}; }

 private:
  struct Bin {  // means over the images of one pixel of depth
    int count = 0;
    double depth = 0, value = 0, variance = 0;  // value: shown minus computed
  };

  void Fit(double model, double edge) noexcept {
    Eigen::Matrix2d A;  // information of f and offset
    A << 1 / (model * model), 0, 0, 0;
    Eigen::Vector2d b(0, 0);
    for (const Bin& bin : bins_) {
      if (bin.count == 0) continue;
      const double weight = 1 / (edge * edge + bin.variance / bin.count);
      const Eigen::Vector2d row(bin.depth, -1);
      A += weight * row * row.transpose();
      b += weight * bin.value * row;
    }
    const Eigen::Matrix2d C = A.inverse();
    value_ = (C * b)[1];
    sigma_ = std::sqrt(C(1, 1));
  }

  // Indentation from which on an image shows one [sigma]. [by definition]
  static constexpr double kShows = 2;
  // Largest depth; a deeper indentation would leave the image.
  static constexpr std::size_t kDeepest = 256;  // [px]
  std::array<Bin, kDeepest> bins_{};
  double value_ = 0, sigma_ = HUGE_VAL;
};

}  // namespace palpate
