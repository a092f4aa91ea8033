// The membrane broke: stated by one camera before any force is (paper A, 4.2, which sets the force
// to zero when the pipette overshoots).
//
// Three things come together. Overshoot: the tip is at least so deep behind the rest surface as the
// scene says that membranes break. Velocity: the tool was driven in, or is where it was driven;
// a tool that retreats breaks nothing. Force residual: what a model makes of the surface's shape.
// With a linear model the force is proportional to the indentation, so the indentation that is
// seen, in parts of the indentation that the tip's place asks for, is the part of the force that is
// still there.
#pragma once

#include <algorithm>

namespace palpate {

class PunctureCue {
 public:
  static constexpr double kGone = 0.4;          // part of the force at which it is gone
  static constexpr double kSigmas = 2;          // by which it must be less
  static constexpr double kMinIndentation = 8;  // that is to be expected [px]
  static constexpr double kRetreat =
      0.15;  // of the largest depth: a tool that is so much shallower retreats
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
  // Whether the indentation at `depth` [m] may have vanished: requests a second check.
  [[nodiscard]] bool IsArmed(double depth) const noexcept { return from_ > 0 && depth >= from_; }
  // Once per image in contact. True: the membrane is punctured.
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
