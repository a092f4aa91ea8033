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

constexpr int kMaxModalSteps = 30;
// Resolution below which short waves are ignored, as at the rim.
constexpr double kNoShortWaves = 1e-12;

}  // namespace

ModalPlate::ModalPlate(const PlateModes& modes, double D, double prestress)
    : modes_(modes), D_(D), prestress_(prestress) {}

void ModalPlate::Place(std::span<const Press> presses, Symmetry symmetry) {
  const int modes = modes_.deflections(symmetry);
  if (modes != amplitudes_.size()) {
    symmetry_ = symmetry;
    amplitudes_.setZero(modes);
    for (Eigen::VectorXd* v : {&gradient_, &step_, &point_}) v->resize(modes);
    stress_.resize(modes_.stresses(symmetry));
    pull_.resize(stress_.size(), modes);
    tangent_.resize(modes, modes);
  }
  presses_.assign(presses.begin(), presses.end());
  ListPlaces();
  const Index count = firsts_.back();
  const auto contacts = static_cast<Index>(presses_.size());
  if (count != forces_.size()) {
    for (Eigen::VectorXd* v : {&forces_, &deflections_, &free_, &next_}) v->setZero(count);
    compliance_.resize(count, count);
    short_.resize(count, count);
  }
  at_.resize(modes, count);
  load_.resize(modes, count);
  by_load_.resize(modes, count);
  centres_.resize(modes, contacts);
  resolution_.resize(contacts);
  near_.resize(contacts, contacts);
  for (Index k = 0; k < count; ++k) {
    // The mirror image of a place has the same modes.
    const Disc& disc = places_[static_cast<std::size_t>(k)].disc;
    modes_.Evaluate(disc.centre, at_.col(k));
    if (disc.radius > 0) {
      modes_.Mean(disc, load_.col(k));
    } else {
      load_.col(k) = at_.col(k);
    }
  }
  for (Index j = 0; j < count; ++j) {
    const plate::PressedPlace& load = places_[static_cast<std::size_t>(j)];
    for (Index i = 0; i < count; ++i) {
      const Eigen::Vector2d& x = places_[static_cast<std::size_t>(i)].disc.centre;
      short_(i, j) = (plate::Deflection(load, x) - at_.col(i).dot(load_.col(j))) / D_;
    }
  }
  CompareShortWaves();
}

void ModalPlate::ListPlaces() {
  places_.clear();
  contact_of_.clear();
  firsts_.assign(1, 0);
  pressed_.Clear();
  for (const Press& press : presses_) {
    AppendPlaces(press.disc, press.face, symmetry_ != Symmetry::kNone, &places_);
    const Index first = firsts_.back();
    firsts_.push_back(static_cast<Index>(places_.size()));
    contact_of_.resize(places_.size(), firsts_.size() - 2);
    if (!press.is_sought()) continue;
    pressed_.Add({first, firsts_.back() - first, press.face == Face::kRigid, press.is_force});
  }
  sought_.resize(pressed_.bodies().size());
}

// Compares points at the contacts' centres.
void ModalPlate::CompareShortWaves() {
  const auto contacts = static_cast<Index>(presses_.size());
  const auto centre = [this](Index s) -> const Eigen::Vector2d& {
    return presses_[static_cast<std::size_t>(s)].disc.centre;
  };
  for (Index s = 0; s < contacts; ++s) {
    modes_.Evaluate(centre(s), centres_.col(s));
    resolution_[s] = plate::Deflection(centre(s), centre(s)) - centres_.col(s).squaredNorm();
  }
  for (Index s = 0; s < contacts; ++s) {
    for (Index t = 0; t < contacts; ++t) {
      const double between =
          plate::Deflection(centre(t), centre(s)) - centres_.col(s).dot(centres_.col(t));
      near_(s, t) = resolution_[s] > kNoShortWaves ? between / resolution_[s] : 0;
    }
  }
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
  for (int iteration = 0; iteration < kMaxModalSteps; ++iteration) {
    if (!Linearise()) return false;
    Comply();
    // Computes first the amplitudes for unchanged unknown forces.
    step_ = -gradient_;
    factor_.solveInPlace(step_);
    if (!SeekForces(share)) return false;
    next_ -= forces_;
    step_.noalias() += by_load_ * next_;
    forces_ += next_;
    amplitudes_ += step_;
    const double change = LargestEntry(step_), force_change = LargestEntry(next_);
    if (!std::isfinite(change) || !std::isfinite(force_change)) return false;
    if (change <= kConverged * LargestEntry(amplitudes_) &&
        force_change <= kConverged * LargestEntry(forces_)) {
      NoteDeflections();
      return true;
    }
  }
  return false;
}

// Computes next_, the forces after the step, of contacts with unknown forces.
bool ModalPlate::SeekForces(double share) noexcept {
  free_ = at_.transpose() * (amplitudes_ + step_);
  for (Index k = 0; k < free_.size(); ++k) free_[k] += ShortWavesAt(k);
  next_ = forces_;
  for (std::size_t b = 0, s = 0; s < presses_.size(); ++s) {
    if (!presses_[s].is_sought()) continue;
    for (Index k = firsts_[s]; k < firsts_[s + 1]; ++k) free_ -= compliance_.col(k) * forces_[k];
    sought_[b++] = share * presses_[s].value;
  }
  pressed_.Renew();
  return pressed_.Solve(compliance_, free_, sought_, &next_);
}

void ModalPlate::NoteDeflections() noexcept {
  deflections_.noalias() = at_.transpose() * amplitudes_;
  for (Index k = 0; k < deflections_.size(); ++k) deflections_[k] += ShortWavesAt(k);
}

ModalPlate::Answer ModalPlate::AnswerOf(std::size_t contact) const noexcept {
  const Index first = firsts_[contact], count = firsts_[contact + 1] - first;
  const auto forces = forces_.segment(first, count);
  Answer answer{.force = forces.sum(), .deflection = deflections_[first]};
  if (!presses_[contact].is_sought()) {
    answer.stiffness = pressed_.StiffnessAt(compliance_, first);
    return answer;
  }
  const auto body = static_cast<std::size_t>(std::ranges::count_if(
      presses_.begin(), presses_.begin() + static_cast<long>(contact), &Press::is_sought));
  answer.deflection = pressed_.deflection(body);
  answer.stiffness = pressed_.Stiffness(body);
  return answer;
}

double ModalPlate::ForceNear(std::size_t contact) const noexcept {
  double force = 0;
  for (std::size_t t = 0; t < presses_.size(); ++t) {
    force += near_(static_cast<Index>(contact), static_cast<Index>(t)) *
             forces_.segment(firsts_[t], firsts_[t + 1] - firsts_[t]).sum();
  }
  return force;
}

double ModalPlate::ShortWavesAt(Index place) const noexcept {
  const std::size_t contact = ContactOf(place);
  const double bending = short_.row(place).dot(forces_);
  const ShortWaves* waves = presses_[contact].waves;
  if (waves == nullptr) return bending;
  const double resolution = resolution_[static_cast<Index>(contact)];
  return bending + waves->At(ForceNear(contact), resolution).deflection;
}

// Adds the forces of contacts with a uniform load.
void ModalPlate::AddForces(double share) noexcept {
  for (std::size_t s = 0; s < presses_.size(); ++s) {
    if (!presses_[s].is_sought()) forces_[firsts_[s]] = share * presses_[s].value;
  }
}

// Computes the gradient of the energy at the amplitudes and factorises its tangent. Returns false
// if the energy is not convex there.
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

// Computes pull_, stress_ (c_k = a^T G_k a / 2), and tangent_ (sum_k c_k G_k).
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
  for (std::size_t s = 0; s < presses_.size(); ++s) {
    const ShortWaves* waves = presses_[s].waves;
    if (waves == nullptr) continue;
    const auto contact = static_cast<Index>(s);
    const double more = waves->At(ForceNear(s), resolution_[contact]).compliance;
    for (Index j = 0; j < compliance_.cols(); ++j) {
      compliance_.col(j).segment(firsts_[s], firsts_[s + 1] - firsts_[s]).array() +=
          more * near_(contact, static_cast<Index>(ContactOf(j)));
    }
  }
}

// Returns the deflection at `x` including short waves, which use the width of the nearest contact.
double ModalPlate::Deflection(const Eigen::Vector2d& x) noexcept {
  modes_.Evaluate(x, point_);
  double w = point_.dot(amplitudes_);
  for (Index k = 0; k < forces_.size(); ++k) {
    if (forces_[k] == 0) continue;
    const plate::PressedPlace& place = places_[static_cast<std::size_t>(k)];
    w += (plate::Deflection(place, x) - point_.dot(load_.col(k))) / D_ * forces_[k];
  }
  const double resolution = plate::Deflection(x, x) - point_.squaredNorm();
  const ShortWaves* waves = nullptr;
  double force = 0, nearest = 0;
  for (std::size_t s = 0; s < presses_.size(); ++s) {
    const Press& press = presses_[s];
    const double between =
        plate::Deflection(press.disc.centre, x) - point_.dot(centres_.col(static_cast<Index>(s)));
    force += between * forces_.segment(firsts_[s], firsts_[s + 1] - firsts_[s]).sum();
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
constexpr double kFiner[] = {1, 1.25, 1.5, 2, 3};  // numbers of modes relative to the plate's own
constexpr std::size_t kMaxKept = 16;

ShortWaves::ShortWaves(int order, double nu, double prestress, double load_radius, Face face)
    : load_radius_(load_radius), face_(face) {
  const double D = 1 / (12 * (1 - nu * nu));
  const ModalPlate::Press press{.disc = {{0, 0}, load_radius}, .face = face, .is_force = true};
  const Eigen::Vector2d centre(0, 0);
  RoundPress exact(nu, load_radius, prestress, face);
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
  for (Level& level : levels_) level.entries.emplace_back();  // at rest the plate bends only
  for (int n = 1; n < kEntries; ++n) {
    bool solved = exact.SolveDeflection(kLinear * std::sinh(kStep * n));
    for (std::size_t level = 0; level < modal.size(); ++level) {
      ModalPlate& plate = *modal[level];
      const std::array force = {exact.force()};
      solved = solved && plate.Solve(force);
      if (!solved)
        throw std::runtime_error("the plate's response to a central indentation is not found");
      const ModalPlate::Answer answer = plate.AnswerOf(0);
      levels_[level].entries.push_back(
          {exact.force(),
           {exact.deflection() - answer.deflection, 1 / exact.stiffness() - 1 / answer.stiffness}});
    }
  }
}

std::shared_ptr<const ShortWaves> ShortWaves::Of(int order, double nu, double prestress,
                                                 double load_radius, Face face) {
  using Plate = std::array<double, 5>;
  static std::mutex mutex;
  static std::deque<std::pair<Plate, std::shared_ptr<const ShortWaves>>> kept;
  const Plate plate{static_cast<double>(order), nu, prestress, load_radius,
                    face == Face::kRigid ? 1.0 : 0.0};
  {
    const std::lock_guard lock(mutex);
    const auto known = std::ranges::find(kept, plate, [](const auto& one) { return one.first; });
    if (known != kept.end()) {
      std::rotate(kept.begin(), known, known + 1);
      return kept.front().second;
    }
  }
  auto waves = std::make_shared<const ShortWaves>(order, nu, prestress, load_radius, face);
  const std::lock_guard lock(mutex);
  kept.emplace_front(plate, waves);
  if (kept.size() > kMaxKept) kept.pop_back();
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
