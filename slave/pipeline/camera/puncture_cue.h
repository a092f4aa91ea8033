// Detects with one camera that the membrane broke (paper A, 4.2, which sets the force to zero when
// the pipette overshoots).
//
// Three conditions must hold. Overshoot: the tip is behind the rest surface at least by the depth
// at which membranes break according to the scene. Velocity: the tool was moving in, or has not
// retreated since; a retreating tool cannot puncture. Force residual: with a linear model the force
// is proportional to the indentation, so the measured indentation divided by the one expected for
// the tip's position is the remaining share of the force.
#pragma once

#include <algorithm>

namespace palpate {

class PunctureCue {
 public:
  static constexpr double kGone = 0.4;  // remaining share below which the force counts as zero
  static constexpr double kSigmas = 2;  // number of sigmas by which the share must be below kGone
  static constexpr double kMinIndentation = 8;  // smallest expected indentation [px]
  static constexpr double kRetreat =
      // Decrease of the depth, relative to the largest one, after which the tool counts as
      // retreating.
      0.15;
  static constexpr int kUnseenIndentation =
      2;  // images that must agree if no indentation was detected before

  // Measurements of one image with a tool in contact. Along the surface's normal, inwards.
  struct Sample {
    double depth = 0;                // of the tip behind the rest surface [m]
    double expected_px = 0;          // indentation that follows from it [px]
    bool indentation_known = false;  // the edge next to the tool shows the indentation
    double seen_px = 0;              // measured indentation [px]
    double sigma_px = 0;             // sigma of the measured indentation [px]
  };

  // `from`: depth from which membranes may break [m]; 0: no check.
  void Adopt(double from) noexcept { from_ = from; }
  // The tool left, or the sensing was reset.
  void Reset() noexcept { deepest_ = 0, gone_ = 0, was_dented_ = false; }
  // Returns whether the indentation at `depth` [m] may have vanished, which requires a second
  // check.
  [[nodiscard]] bool IsArmed(double depth) const noexcept { return from_ > 0 && depth >= from_; }
  // Call it once per image in contact. Returns whether the membrane is punctured.
  [[nodiscard]] bool Broke(const Sample& look) noexcept {
    deepest_ = std::max(deepest_, look.depth);
    if (!look.indentation_known || look.expected_px < kMinIndentation) return false;
    const double most = look.seen_px + kSigmas * look.sigma_px;
    const bool is_gone = most < kGone * look.expected_px;
    was_dented_ |= look.seen_px - kSigmas * look.sigma_px > kGone * look.expected_px;
    gone_ = is_gone ? gone_ + 1 : 0;
    const bool overshot = IsArmed(look.depth);
    const bool is_driven = look.depth > (1 - kRetreat) * deepest_;
    return overshot && is_driven && gone_ >= (was_dented_ ? 1 : kUnseenIndentation);
  }

 private:
  double from_ = 0;
  double deepest_ = 0;       // in this contact [m]
  int gone_ = 0;             // consecutive images without the indentation
  bool was_dented_ = false;  // in this contact
};

}  // namespace palpate
