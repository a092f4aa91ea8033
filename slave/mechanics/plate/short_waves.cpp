#include "slave/mechanics/plate/short_waves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <stdexcept>

#include "slave/mechanics/plate/green.h"
#include "slave/mechanics/plate/modal_plate.h"
#include "slave/mechanics/plate/plate_modes.h"
#include "slave/mechanics/plate/round_press.h"

namespace palpate::plate {
namespace {

constexpr double kLinear = 0.1;  // deflections below it are spaced evenly, above geometrically
constexpr double kStep = 0.08;
constexpr int kEntries = 104;                      // to 190 thicknesses
constexpr double kFiner[] = {1, 1.25, 1.5, 2, 3};  // modes against the plate's own number

}  // namespace

ShortWaves::ShortWaves(int order, double nu, double prestress, double load_radius)
    : load_radius_(load_radius) {
  const double D = 1 / (12 * (1 - nu * nu));
  const ModalPlate::Press press{.disc = {{0, 0}, load_radius}, .is_force = true};
  const Eigen::Vector2d centre(0, 0);
  RoundPress exact(nu, load_radius, prestress);
  std::vector<PlateModes> modes;
  std::vector<std::unique_ptr<ModalPlate>> modal;
  for (const double finer : kFiner) {
    const int level = 2 * static_cast<int>(std::lround(finer * order / 2));
    if (modes.empty() || level > modes.back().order()) {
      modes.emplace_back(level, nu, Symmetry::kRound);
    }
  }
  for (const PlateModes& m : modes) {
    modal.push_back(std::make_unique<ModalPlate>(m, D, prestress));
    modal.back()->Place(std::span(&press, 1), Symmetry::kRound);
    Eigen::VectorXd at(m.deflections(Symmetry::kRound));
    m.Evaluate(centre, at);
    levels_.push_back({Deflection(centre, centre) - at.squaredNorm(), {}});
  }
  for (int n = 0; n < kEntries; ++n) {
    bool solved = exact.SolveDeflection(kLinear * std::sinh(kStep * n));
    for (std::size_t level = 0; level < modal.size(); ++level) {
      ModalPlate& plate = *modal[level];
      const std::array force = {exact.force()};
      solved = solved && plate.Solve(force);
      if (!solved) throw std::runtime_error("the plate's response to a central press is not found");
      levels_[level].entries.push_back({exact.force(),
                                        {exact.deflection() - plate.deflections()[0],
                                         1 / exact.stiffness() - plate.compliance()(0, 0)}});
    }
  }
}

ShortWaves::Share ShortWaves::At(double force, double resolution) const noexcept {
  std::size_t finer = 1;
  while (finer < levels_.size() && levels_[finer].resolution > resolution) ++finer;
  const Level& coarse = levels_[finer - 1];
  const bool beyond = finer == levels_.size();
  const double fine_resolution = beyond ? 0 : levels_[finer].resolution;
  const double mix = (resolution - fine_resolution) / (coarse.resolution - fine_resolution);
  const Share a = Interpolate(coarse, std::abs(force));
  const Share b = beyond ? Share{} : Interpolate(levels_[finer], std::abs(force));
  const double sign = force < 0 ? -1 : 1;
  return {sign * (mix * a.deflection + (1 - mix) * b.deflection),
          mix * a.compliance + (1 - mix) * b.compliance};
}

// Hermite's cubics between tabulated values and slopes, straight beyond.
ShortWaves::Share ShortWaves::Interpolate(const Level& level, double force) noexcept {
  const auto above = std::ranges::upper_bound(level.entries, force, {}, &Entry::force);
  if (above == level.entries.end()) {
    const auto& [last, share] = level.entries.back();
    return {share.deflection + (force - last) * share.compliance, share.compliance};
  }
  const auto& [right, at_right] = *above;
  const auto& [left, at_left] = *(above - 1);
  const double width = right - left;
  const double x = (force - left) / width;
  const double rise = (at_right.deflection - at_left.deflection) / width;
  const double bow = at_left.compliance + at_right.compliance - 2 * rise;
  const double bend = 3 * rise - 2 * at_left.compliance - at_right.compliance;
  return {at_left.deflection + width * x * (at_left.compliance + x * (bend + x * bow)),
          at_left.compliance + x * (2 * bend + 3 * x * bow)};
}

}  // namespace palpate::plate
