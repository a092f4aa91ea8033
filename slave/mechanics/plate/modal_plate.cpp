#include "slave/mechanics/plate/modal_plate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "slave/mechanics/plate/round_press.h"

namespace palpate::plate {
namespace {

using Eigen::Index;

constexpr int kIterations = 30;
constexpr double kConverged = 1e-7;      // last relative step: Newton squares it
constexpr double kNoShortWaves = 1e-12;  // resolution at the very rim

}  // namespace

ModalPlate::ModalPlate(const PlateModes& modes, double D, double prestress)
    : modes_(modes), D_(D), prestress_(prestress) {}

void ModalPlate::Place(std::span<const Press> presses, Symmetry symmetry) {
  const int modes = modes_.deflections(symmetry);
  const auto count = static_cast<Index>(presses.size());
  if (modes != amplitudes_.size()) {
    symmetry_ = symmetry;
    amplitudes_.setZero(modes);
    gradient_.resize(modes);
    step_.resize(modes);
    point_.resize(modes);
    stress_.resize(modes_.stresses(symmetry));
    pull_.resize(stress_.size(), modes);
    tangent_.resize(modes, modes);
  }
  if (count != forces_.size()) {
    forces_.setZero(count);
    deflections_.setZero(count);
    compliance_.resize(count, count);
    short_.resize(count, count);
    resolution_.resize(count);
    near_.resize(count, count);
  }
  at_.resize(modes, count);
  load_.resize(modes, count);
  by_load_.resize(modes, count);
  presses_.assign(presses.begin(), presses.end());
  moved_.Clear();
  for (Index s = 0; s < count; ++s) {
    const Press& press = presses_[static_cast<std::size_t>(s)];
    modes_.Evaluate(press.disc.centre, at_.col(s));
    modes_.Mean(press.disc, load_.col(s));
    if (!press.is_force) moved_.Add(s);
    const Eigen::Vector2d& centre = press.disc.centre;
    resolution_[s] = plate::Deflection(centre, centre) - at_.col(s).squaredNorm();
  }
  for (Index s = 0; s < count; ++s) {
    const Eigen::Vector2d& centre = presses_[static_cast<std::size_t>(s)].disc.centre;
    for (Index t = 0; t < count; ++t) {
      const Disc& load = presses_[static_cast<std::size_t>(t)].disc;
      const double between = plate::Deflection(load.centre, centre) - at_.col(s).dot(at_.col(t));
      near_(s, t) = resolution_[s] > kNoShortWaves ? between / resolution_[s] : 0;
      short_(s, t) = (plate::Deflection(load, centre) - at_.col(s).dot(load_.col(t))) / D_;
    }
  }
  more_.resize(static_cast<Index>(moved_.contacts().size()));
}

void ModalPlate::Reset() noexcept {
  amplitudes_.setZero();
  forces_.setZero();
  deflections_.setZero();
}

bool ModalPlate::Solve(std::span<const double> values) noexcept {
  double largest = 0;
  for (std::size_t s = 0; s < values.size(); ++s) {
    presses_[s].value = values[s];
    if (!std::isfinite(values[s])) return false;
    largest = std::max(largest, std::abs(values[s]));
  }
  return SolveBySteps(
      2 * largest, [&](double share) { return Newton(share); }, [&] { Reset(); });
}

bool ModalPlate::Newton(double share) noexcept {
  AddForces(share);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    if (!Linearise()) return false;
    Comply();
    if (!moved_.Factorise(compliance_)) return false;
    // The amplitudes first as they would be without a change of the moved contacts' forces.
    step_ = -gradient_;
    factor_.solveInPlace(step_);
    Demand(share);
    moved_.Solve(more_);
    double force_change = 0;
    for (std::size_t m = 0; m < moved_.contacts().size(); ++m) {
      const double more = more_[static_cast<Index>(m)];
      step_ += more * by_load_.col(moved_.contacts()[m]);
      forces_[moved_.contacts()[m]] += more;
      force_change = std::max(force_change, std::abs(more));
    }
    amplitudes_ += step_;
    const double change = LargestEntry(step_);
    if (!std::isfinite(change) || !std::isfinite(force_change)) return false;
    if (change <= kConverged * LargestEntry(amplitudes_) &&
        force_change <= kConverged * LargestEntry(forces_)) {
      Answer(share);
      return true;
    }
  }
  return false;
}

// What is missing at the moved contacts after the step.
void ModalPlate::Demand(double share) noexcept {
  for (std::size_t m = 0; m < moved_.contacts().size(); ++m) {
    const Index s = moved_.contacts()[m];
    const double modes = at_.col(s).dot(amplitudes_) + at_.col(s).dot(step_);
    more_[static_cast<Index>(m)] =
        share * presses_[static_cast<std::size_t>(s)].value - modes - ShortWavesAt(s);
  }
}

void ModalPlate::Answer(double share) noexcept {
  for (Index s = 0; s < forces_.size(); ++s) {
    const Press& press = presses_[static_cast<std::size_t>(s)];
    deflections_[s] =
        press.is_force ? at_.col(s).dot(amplitudes_) + ShortWavesAt(s) : share * press.value;
  }
}

double ModalPlate::ShortWavesAt(Index contact) const noexcept {
  const Press& press = presses_[static_cast<std::size_t>(contact)];
  const double bending = short_.row(contact).dot(forces_);
  if (press.waves == nullptr) return bending;
  const double force = near_.row(contact).dot(forces_);
  return bending + press.waves->At(force, resolution_[contact]).deflection;
}

void ModalPlate::AddForces(double share) noexcept {
  for (std::size_t s = 0; s < presses_.size(); ++s) {
    if (presses_[s].is_force) forces_[static_cast<Index>(s)] = share * presses_[s].value;
  }
}

// The energy's gradient at the amplitudes, and its tangent's factor. False: not convex there.
bool ModalPlate::Linearise() noexcept {
  Stretch();
  gradient_ = D_ * amplitudes_;
  gradient_.noalias() += pull_.transpose() * stress_;
  gradient_.noalias() -= load_ * forces_;
  if (prestress_ > 0) {
    const auto size = amplitudes_.size();
    const auto P = modes_.slope_energy().topLeftCorner(size, size);
    gradient_.noalias() += prestress_ * (P * amplitudes_);
    tangent_ += prestress_ * P;
  }
  tangent_.diagonal().array() += D_;
  tangent_.selfadjointView<Eigen::Lower>().rankUpdate(pull_.transpose());
  factor_.compute(tangent_);
  return factor_.info() == Eigen::Success;
}

// pull_, stress_ c_k = a^T G_k a / 2, and sum_k c_k G_k into tangent_.
void ModalPlate::Stretch() noexcept {
  pull_.setZero();
  tangent_.setZero();
  const std::size_t blocks = modes_.blocks(symmetry_);
  for (std::size_t n = 0; n < blocks; ++n) {
    const PlateModes::Block& block = modes_.blocks()[n];
    const double* G = block.values.data();
    const bool square = block.first_i == block.first_j;
    for (int i = 0; i < block.count_i; ++i) {
      double* pull_i = &pull_(block.first_k, block.first_i + i);
      const double a_i = amplitudes_[block.first_i + i];
      for (int j = 0; j < block.count_j; ++j, G += block.count_k) {
        double* pull_j = &pull_(block.first_k, block.first_j + j);
        const double a_j = amplitudes_[block.first_j + j];
        for (int k = 0; k < block.count_k; ++k) pull_i[k] += G[k] * a_j;
        if (square) continue;
        for (int k = 0; k < block.count_k; ++k) pull_j[k] += G[k] * a_i;
      }
    }
  }
  stress_.noalias() = 0.5 * (pull_ * amplitudes_);
  for (std::size_t n = 0; n < blocks; ++n) {
    const PlateModes::Block& block = modes_.blocks()[n];
    const double* G = block.values.data();
    const double* c = &stress_[block.first_k];
    for (int i = 0; i < block.count_i; ++i) {
      double* column = &tangent_(block.first_j, block.first_i + i);
      for (int j = 0; j < block.count_j; ++j, G += block.count_k) {
        double sum = 0;
        for (int k = 0; k < block.count_k; ++k) sum += G[k] * c[k];
        column[j] += sum;
      }
    }
  }
}

void ModalPlate::Comply() noexcept {
  by_load_ = load_;
  factor_.solveInPlace(by_load_);
  compliance_ = short_;
  compliance_.noalias() += at_.transpose() * by_load_;
  for (Index s = 0; s < forces_.size(); ++s) {
    const Press& press = presses_[static_cast<std::size_t>(s)];
    if (press.waves == nullptr) continue;
    const double force = near_.row(s).dot(forces_);
    compliance_.row(s) += press.waves->At(force, resolution_[s]).compliance * near_.row(s);
  }
}

// As at a contact that stood there, of the width of the one that is nearest in short waves.
double ModalPlate::Deflection(const Eigen::Vector2d& x) noexcept {
  modes_.Evaluate(x, point_);
  double w = point_.dot(amplitudes_);
  const double resolution = plate::Deflection(x, x) - point_.squaredNorm();
  const ShortWaves* waves = nullptr;
  double force = 0, nearest = 0;
  for (Index s = 0; s < forces_.size(); ++s) {
    const Press& press = presses_[static_cast<std::size_t>(s)];
    w += (plate::Deflection(press.disc, x) - point_.dot(load_.col(s))) / D_ * forces_[s];
    const double between = plate::Deflection(press.disc.centre, x) - point_.dot(at_.col(s));
    force += between * forces_[s];
    if (std::abs(between) <= nearest) continue;
    nearest = std::abs(between);
    waves = press.waves;
  }
  if (waves != nullptr && resolution > kNoShortWaves) {
    w += waves->At(force / resolution, resolution).deflection;
  }
  return w;
}

constexpr double kLinear = 0.1;  // deflections below it are spaced evenly, above geometrically
constexpr double kStep = 0.08;
constexpr int kEntries = 104;                      // to 190 thicknesses
constexpr double kFiner[] = {1, 1.25, 1.5, 2, 3};  // modes against the plate's own number
constexpr std::size_t kKept = 16;

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
      if (!solved)
        throw std::runtime_error("the plate's response to a central indentation is not found");
      levels_[level].entries.push_back({exact.force(),
                                        {exact.deflection() - plate.deflections()[0],
                                         1 / exact.stiffness() - plate.compliance()(0, 0)}});
    }
  }
}

std::shared_ptr<const ShortWaves> ShortWaves::Of(int order, double nu, double prestress,
                                                 double load_radius) {
  using Plate = std::array<double, 4>;
  static std::mutex mutex;
  static std::deque<std::pair<Plate, std::shared_ptr<const ShortWaves>>> kept;
  const Plate plate{static_cast<double>(order), nu, prestress, load_radius};
  {
    const std::lock_guard lock(mutex);
    const auto known = std::ranges::find(kept, plate, [](const auto& one) { return one.first; });
    if (known != kept.end()) {
      std::rotate(kept.begin(), known, known + 1);
      return kept.front().second;
    }
  }
  auto waves = std::make_shared<const ShortWaves>(order, nu, prestress, load_radius);
  const std::lock_guard lock(mutex);
  kept.emplace_front(plate, waves);
  if (kept.size() > kKept) kept.pop_back();
  return waves;
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
