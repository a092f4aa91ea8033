#include "slave/mechanics/plate/modal_plate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

#include "slave/mechanics/plate/contacts.h"

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
  presses_.assign(presses.begin(), presses.end());
  Divide();
  const auto count = static_cast<Index>(parts_.size());
  const auto contacts = static_cast<Index>(presses_.size());
  if (count != forces_.size() || contacts != totals_.size()) {
    forces_.setZero(count);
    totals_.setZero(contacts);
    deflections_.setZero(contacts);
    compliance_.resize(count, count);
    short_.resize(count, count);
    resolution_.resize(contacts);
    near_.resize(contacts, contacts);
  }
  load_.resize(modes, count);
  by_load_.resize(modes, count);
  centre_.resize(modes, contacts);
  FillShortWaves();
  more_.resize(static_cast<Index>(moved_.contacts().size()));
}

void ModalPlate::Divide() {
  parts_.clear();
  contact_.clear();
  first_.clear();
  moved_.Clear();
  for (std::size_t s = 0; s < presses_.size(); ++s) {
    const Press& press = presses_[s];
    first_.push_back(static_cast<Index>(parts_.size()));
    if (press.rigid) {
      for (const auto& point : ToolPoints(press.disc)) parts_.push_back({point, 0});
    } else {
      parts_.push_back(press.disc);
    }
    contact_.resize(parts_.size(), s);
    if (press.is_force) continue;
    for (auto i = first_.back(); i < static_cast<Index>(parts_.size()); ++i) moved_.Add(i);
  }
  first_.push_back(static_cast<Index>(parts_.size()));
}

void ModalPlate::FillShortWaves() {
  for (Index i = 0; i < load_.cols(); ++i) {
    modes_.Mean(parts_[static_cast<std::size_t>(i)], load_.col(i));
  }
  for (Index i = 0; i < load_.cols(); ++i) {
    for (Index j = 0; j < load_.cols(); ++j) {
      const double all = plate::MeanDeflection(parts_[static_cast<std::size_t>(j)],
                                               parts_[static_cast<std::size_t>(i)]);
      short_(i, j) = (all - load_.col(i).dot(load_.col(j))) / D_;
    }
  }
  for (Index s = 0; s < centre_.cols(); ++s) {
    const Eigen::Vector2d& centre = presses_[static_cast<std::size_t>(s)].disc.centre;
    modes_.Evaluate(centre, centre_.col(s));
    resolution_[s] = plate::Deflection(centre, centre) - centre_.col(s).squaredNorm();
  }
  for (Index s = 0; s < centre_.cols(); ++s) {
    const Eigen::Vector2d& centre = presses_[static_cast<std::size_t>(s)].disc.centre;
    for (Index t = 0; t < centre_.cols(); ++t) {
      const Eigen::Vector2d& other = presses_[static_cast<std::size_t>(t)].disc.centre;
      const double between = plate::Deflection(other, centre) - centre_.col(s).dot(centre_.col(t));
      near_(s, t) = resolution_[s] > kNoShortWaves ? between / resolution_[s] : 0;
    }
  }
}

// Forces of the contacts, from those of their parts.
void ModalPlate::AddUp() noexcept {
  totals_.setZero();
  for (Index i = 0; i < forces_.size(); ++i) {
    totals_[static_cast<Index>(contact_[static_cast<std::size_t>(i)])] += forces_[i];
  }
}

void ModalPlate::Reset() noexcept {
  amplitudes_.setZero();
  forces_.setZero();
  totals_.setZero();
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
    AddUp();
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
    const double modes = load_.col(s).dot(amplitudes_) + load_.col(s).dot(step_);
    more_[static_cast<Index>(m)] = share * PressOf(s).value - modes - ShortWavesAt(s);
  }
}

void ModalPlate::Answer(double share) noexcept {
  for (Index s = 0; s < deflections_.size(); ++s) {
    const Press& press = presses_[static_cast<std::size_t>(s)];
    const Index part = first_[static_cast<std::size_t>(s)];
    deflections_[s] = press.is_force ? load_.col(part).dot(amplitudes_) + ShortWavesAt(part)
                                     : share * press.value;
  }
}

double ModalPlate::ShortWavesAt(Index part) const noexcept {
  return short_.row(part).dot(forces_) +
         StretchAt(contact_[static_cast<std::size_t>(part)]).deflection;
}

ShortWaves::Share ModalPlate::StretchAt(std::size_t contact) const noexcept {
  const ShortWaves* waves = presses_[contact].waves;
  if (waves == nullptr) return {};
  const auto s = static_cast<Index>(contact);
  return waves->At(near_.row(s).dot(totals_), resolution_[s]);
}

void ModalPlate::AddForces(double share) noexcept {
  for (Index i = 0; i < forces_.size(); ++i) {
    if (PressOf(i).is_force) forces_[i] = share * PressOf(i).value;
  }
  AddUp();
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
  compliance_.noalias() += load_.transpose() * by_load_;
  for (std::size_t s = 0; s < presses_.size(); ++s) {
    const double stretch = StretchAt(s).compliance;
    if (stretch == 0) continue;
    for (Index j = 0; j < forces_.size(); ++j) {
      const auto t = static_cast<Index>(contact_[static_cast<std::size_t>(j)]);
      compliance_.col(j).segment(first_[s], first_[s + 1] - first_[s]).array() +=
          stretch * near_(static_cast<Index>(s), t);
    }
  }
}

// As at a contact that stood there, of the width of the one that is nearest in short waves.
double ModalPlate::Deflection(const Eigen::Vector2d& x) noexcept {
  modes_.Evaluate(x, point_);
  double w = point_.dot(amplitudes_);
  for (Index i = 0; i < forces_.size(); ++i) {
    const Disc& disc = parts_[static_cast<std::size_t>(i)];
    w += (plate::Deflection(disc, x) - point_.dot(load_.col(i))) / D_ * forces_[i];
  }
  const double resolution = plate::Deflection(x, x) - point_.squaredNorm();
  const ShortWaves* waves = nullptr;
  double force = 0, nearest = 0;
  for (Index s = 0; s < totals_.size(); ++s) {
    const Press& press = presses_[static_cast<std::size_t>(s)];
    const double between = plate::Deflection(press.disc.centre, x) - point_.dot(centre_.col(s));
    force += between * totals_[s];
    if (std::abs(between) <= nearest) continue;
    nearest = std::abs(between);
    waves = press.waves;
  }
  if (waves != nullptr && resolution > kNoShortWaves) {
    w += waves->At(force / resolution, resolution).shape;
  }
  return w;
}

constexpr double kLinear = 0.1;  // deflections below it are spaced evenly, above geometrically
constexpr double kStep = 0.08;
constexpr int kEntries = 104;                      // to 190 thicknesses
constexpr double kFiner[] = {1, 1.25, 1.5, 2, 3};  // modes against the plate's own number
constexpr std::size_t kKept = 16;

namespace {

// The modes' deflection under a force on the contact at the centre, and its derivative. A tool that
// is moved: by Newton's method on the depth, from `depth` on.
std::optional<ShortWaves::Share> SolveForce(double force, double depth, ModalPlate& plate,
                                            bool moved) {
  constexpr int kMost = 20;
  constexpr double kClose = 1e-9;  // of the force
  double value = moved ? depth : force;
  for (int step = 0; step < kMost && plate.Solve(std::array{value}); ++step) {
    const double missing = force - plate.forces()[0];
    if (std::abs(missing) <= kClose * std::abs(force)) {
      return ShortWaves::Share{plate.deflections()[0], 1 / plate.Stiffness(0),
                               plate.Deflection({0, 0})};
    }
    value += missing / plate.Stiffness(0);
  }
  return std::nullopt;
}

}  // namespace

ShortWaves::ShortWaves(int order, double nu, double prestress, const RoundTool& tool)
    : tool_(tool) {
  const double D = 1 / (12 * (1 - nu * nu));
  const ModalPlate::Press press{
      .disc = {{0, 0}, tool.radius}, .is_force = !tool.rigid, .rigid = tool.rigid};
  const Eigen::Vector2d centre(0, 0);
  RoundPress exact(nu, tool, prestress);
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
    const double depth = kLinear * std::sinh(kStep * n);
    const bool solved = exact.SolveDeflection(depth);
    for (std::size_t level = 0; level < modal.size(); ++level) {
      std::vector<Entry>& entries = levels_[level].entries;
      const double guess = depth - (n == 0 ? 0 : Beyond(entries.back(), exact.force()).deflection);
      const auto modal_share = SolveForce(exact.force(), guess, *modal[level], tool.rigid);
      if (!solved || !modal_share)
        throw std::runtime_error("the plate's response to a central indentation is not found");
      entries.push_back({exact.force(),
                         {exact.deflection() - modal_share->deflection,
                          1 / exact.stiffness() - modal_share->compliance,
                          exact.CentreDeflection() - modal_share->shape}});
    }
  }
}

std::shared_ptr<const ShortWaves> ShortWaves::Of(int order, double nu, double prestress,
                                                 const RoundTool& tool) {
  struct Plate {
    int order;
    double nu, prestress;
    RoundTool tool;
    bool operator==(const Plate&) const = default;
  };
  static std::mutex mutex;
  static std::deque<std::pair<Plate, std::shared_ptr<const ShortWaves>>> kept;
  const Plate plate{order, nu, prestress, tool};
  {
    const std::lock_guard lock(mutex);
    const auto known = std::ranges::find(kept, plate, [](const auto& one) { return one.first; });
    if (known != kept.end()) {
      std::rotate(kept.begin(), known, known + 1);
      return kept.front().second;
    }
  }
  auto waves = std::make_shared<const ShortWaves>(order, nu, prestress, tool);
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
  // Without stretching.
  const double linear = levels_.back().entries.front().share.compliance;
  const Share b = beyond ? Share{linear * std::abs(force), linear, 0}
                         : Interpolate(levels_[finer], std::abs(force));
  const double sign = force < 0 ? -1 : 1;
  return {sign * (mix * a.deflection + (1 - mix) * b.deflection),
          mix * a.compliance + (1 - mix) * b.compliance,
          sign * (mix * a.shape + (1 - mix) * b.shape)};
}

ShortWaves::Share ShortWaves::Beyond(const Entry& last, double force) noexcept {
  const Share& share = last.share;
  const double more = (force - last.force) * share.compliance;
  return {share.deflection + more, share.compliance, share.shape + more};
}

// Hermite's cubics between tabulated values and slopes, straight beyond.
ShortWaves::Share ShortWaves::Interpolate(const Level& level, double force) noexcept {
  const auto above = std::ranges::upper_bound(level.entries, force, {}, &Entry::force);
  if (above == level.entries.end()) {
    return Beyond(level.entries.back(), force);
  }
  const auto& [right, at_right] = *above;
  const auto& [left, at_left] = *(above - 1);
  const double width = right - left;
  const double x = (force - left) / width;
  const double rise = (at_right.deflection - at_left.deflection) / width;
  const double bow = at_left.compliance + at_right.compliance - 2 * rise;
  const double bend = 3 * rise - 2 * at_left.compliance - at_right.compliance;
  const double deflection =
      at_left.deflection + width * x * (at_left.compliance + x * (bend + x * bow));
  const double beside_left = at_left.shape - at_left.deflection;
  const double beside_right = at_right.shape - at_right.deflection;
  return {deflection, at_left.compliance + x * (2 * bend + 3 * x * bow),
          deflection + beside_left + x * (beside_right - beside_left)};
}

}  // namespace palpate::plate
