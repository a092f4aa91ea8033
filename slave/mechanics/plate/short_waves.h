// What stretching does to the shapes beyond a plate's modes, by comparison with a press at the
// centre that is solved without modes.
//
// Around a small load the plate looks the same wherever it is pressed: the tension there comes from
// the load itself (in Schwerin's membrane slope and tension depend on the force and the distance
// from it alone, not on the plate's size). So the modes' error at the same force is taken from the
// centre, where it is known: d(F) = w_exact(F) - w_modes(F), with as many modes there as resolve
// the load as finely as it is resolved where it is. d vanishes with the cube of the force where the
// plate bends only; a press at the centre becomes exact.
#pragma once

#include <vector>

namespace palpate::plate {

class ShortWaves {
 public:
  struct Share {
    double deflection = 0, compliance = 0;  // d(F), d'(F)
  };

  // For loads over discs of one radius on a plate with modes of this order, up to deflections of
  // about 200 thicknesses. Tens of milliseconds. Throws std::runtime_error: no convergence.
  ShortWaves(int order, double nu, double prestress, double load_radius);

  // `resolution`: what the shapes beyond the modes add to the compliance under a point load there,
  // by 1 / D. Odd in the force. No allocation.
  [[nodiscard]] Share At(double force, double resolution) const noexcept;
  [[nodiscard]] double load_radius() const { return load_radius_; }

 private:
  struct Entry {
    double force = 0;
    Share share;
  };
  struct Level {  // one number of modes
    double resolution = 0;
    std::vector<Entry> entries;  // rising
  };
  static Share Interpolate(const Level& level, double force) noexcept;

  double load_radius_;
  std::vector<Level> levels_;  // from coarse to fine; the last has no share
};

}  // namespace palpate::plate
