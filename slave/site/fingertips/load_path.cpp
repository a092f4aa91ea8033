#include "slave/site/fingertips/load_path.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace palpate::site {
namespace {

using Eigen::Vector3d;

// Slope at the middle one of three points, zero at an extremum (Fritsch and Carlson's harmonic
// mean, which keeps the cubic monotone).
double MonotoneSlope(double before, double h_before, double after, double h_after) {
  if (!(before * after > 0)) return 0;
  const double w1 = 2 * h_after + h_before, w2 = h_after + 2 * h_before;
  return (w1 + w2) / (w1 / before + w2 / after);
}

struct Bracket {
  std::size_t below = 0;  // rungs below and below + 1
  double part = 0;        // of the way between them
};

Bracket Around(const Rungs& rungs, double s) {
  const auto above = std::ranges::upper_bound(
      rungs, s, {}, [](const std::shared_ptr<const LoadStep>& rung) { return rung->s; });
  const auto index = static_cast<std::size_t>(above - rungs.begin());
  const std::size_t below = std::clamp<std::size_t>(index, 1, rungs.size() - 1) - 1;
  return {below, (s - rungs[below]->s) / (rungs[below + 1]->s - rungs[below]->s)};
}

const FingerTouch& At(const Rungs& rungs, std::size_t rung, int finger) {
  return rungs[rung]->touches[static_cast<std::size_t>(finger)];
}

// One component of the force over the rungs.
class ForceCurve {
 public:
  ForceCurve(const Rungs& rungs, int finger, int component)
      : rungs_(rungs), finger_(finger), component_(component) {}

  [[nodiscard]] double Value(const Bracket& at) const {
    const double f0 = F(at.below), f1 = F(at.below + 1), h = Step(at.below);
    if (at.part > 1) return f1 + (at.part - 1) * (f1 - f0);  // beyond the last rung
    const double t = at.part, u = 1 - t;
    return u * u * ((1 + 2 * t) * f0 + t * h * Slope(at.below)) +
           t * t * ((1 + 2 * u) * f1 - u * h * Slope(at.below + 1));
  }

 private:
  [[nodiscard]] double F(std::size_t i) const { return At(rungs_, i, finger_).force_O[component_]; }
  [[nodiscard]] double Step(std::size_t i) const { return rungs_[i + 1]->s - rungs_[i]->s; }
  [[nodiscard]] double Chord(std::size_t i) const { return (F(i + 1) - F(i)) / Step(i); }
  [[nodiscard]] double Slope(std::size_t i) const {
    if (i == 0) return 0;  // the first touch is soft
    if (i + 1 == rungs_.size()) return Chord(i - 1);
    return MonotoneSlope(Chord(i - 1), Step(i - 1), Chord(i), Step(i));
  }

  const Rungs& rungs_;
  int finger_, component_;
};

}  // namespace

TouchBetween TouchAt(const Rungs& rungs, int finger, double s) noexcept {
  if (rungs.size() < 2 || !(s > rungs.front()->s)) return {};
  const Bracket at = Around(rungs, s);
  const FingerTouch& a = At(rungs, at.below, finger);
  const FingerTouch& b = At(rungs, at.below + 1, finger);
  if (!a.touching && !b.touching) return {};
  TouchBetween result;
  FingerTouch& touch = result.touch;
  touch.touching = true;
  for (int c = 0; c < 3; ++c) touch.force_O[c] = ForceCurve(rungs, finger, c).Value(at);
  const auto between = [&](const auto& from, const auto& to, double part) {
    return from + part * (to - from);
  };
  const double part = std::min(at.part, 1.0);
  touch.p_F = !a.touching ? b.p_F : !b.touching ? a.p_F : Vector3d(between(a.p_F, b.p_F, part));
  touch.radius = between(a.radius, b.radius, part);
  touch.depth = between(a.depth, b.depth, at.part);
  result.slope =
      (b.force_O.norm() - a.force_O.norm()) / (rungs[at.below + 1]->s - rungs[at.below]->s);
  return result;
}

void DisplacementsAt(const Rungs& rungs, double s, std::vector<Vector3d>* displacement_O) {
  if (rungs.empty()) return;
  const std::size_t count = rungs.front()->displacements_O.size();
  displacement_O->assign(count, Vector3d::Zero());
  if (rungs.size() < 2 || !(s > rungs.front()->s)) return;
  const Bracket at = Around(rungs, s);
  const auto part = static_cast<float>(std::min(at.part, 1.0));
  const auto& a = rungs[at.below]->displacements_O;
  const auto& b = rungs[at.below + 1]->displacements_O;
  for (std::size_t i = 0; i < count; ++i) {
    (*displacement_O)[i] = (a[i] + part * (b[i] - a[i])).cast<double>();
  }
}

}  // namespace palpate::site
