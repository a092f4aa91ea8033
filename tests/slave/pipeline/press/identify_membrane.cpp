#include "tests/slave/pipeline/press/identify_membrane.h"

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace palpate {
namespace {

constexpr double kStandsOut = 5;  // sigmas, of a force that counts as contact

bool IsContact(const MembranePress::Reading& reading) {
  return reading.found && reading.own_force > kStandsOut * reading.sigma_own_force;
}

MembranePress MakePress(const MembraneShape& shape, double poisson_ratio, double tension_share,
                        const MembranePress::Params& press) {
  return {InflatedMembrane(
              shape, {.modulus = 1, .poisson_ratio = poisson_ratio, .tension = tension_share}),
          press};
}

struct Misfit {
  double relative = 0;  // to the size of the deflection: mean square of residual / deflection
  double absolute = 0;  // mean square [m^2]
};

// Of the samples in contact. Each counts by the share that is left unexplained: the model is
// linear, and deep dents, which it fits worst, must not decide.
Misfit MisfitOf(MembranePress* press, std::span<const PressSample> samples) {
  Misfit misfit;
  int count = 0;
  for (const PressSample& sample : samples) {
    const auto& reading = press->Fit(sample.points_O);
    if (!IsContact(reading)) continue;
    const double square = reading.residual * reading.residual;
    misfit.absolute += square;
    misfit.relative += square / (reading.deflection * reading.deflection);
    ++count;
  }
  if (count < 3) {
    throw std::invalid_argument(std::to_string(count) +
                                " contacts exceed the noise: accepted is at least 3");
  }
  misfit.absolute /= count;
  misfit.relative /= count;
  return misfit;
}

// Golden section over the logarithm.
double BestTensionShare(const MembraneShape& shape, double poisson_ratio,
                        const MembranePress::Params& params, std::span<const PressSample> samples) {
  constexpr double kLeast = 0.02;
  constexpr double kMost = 2;
  constexpr int kSteps = 9;  // leaves 1.2 % of 4.6
  const auto misfit = [&](double logarithm) {
    MembranePress press = MakePress(shape, poisson_ratio, std::exp(logarithm), params);
    return MisfitOf(&press, samples).relative;
  };
  const double golden = 1 / std::numbers::phi;
  double low = std::log(kLeast);
  double high = std::log(kMost);
  std::array<double, 2> at{high - golden * (high - low), low + golden * (high - low)};
  std::array<double, 2> value{misfit(at[0]), misfit(at[1])};
  for (int step = 0; step < kSteps; ++step) {
    if (value[0] < value[1]) {
      high = at[1];
      at = {high - golden * (high - low), at[0]};
      value = {misfit(at[0]), value[0]};
    } else {
      low = at[0];
      at = {at[1], low + golden * (high - low)};
      value = {value[1], misfit(at[1])};
    }
  }
  return std::exp((low + high) / 2);
}

}  // namespace

StiffnessFit FitStiffness(std::span<const KnownPress> presses, bool with_offset) {
  const std::size_t unknowns = with_offset ? 2 : 1;
  if (presses.size() <= unknowns) {
    throw std::invalid_argument(std::to_string(presses.size()) +
                                " contacts with a known force: accepted is at least " +
                                std::to_string(unknowns + 1));
  }
  const auto count = static_cast<double>(presses.size());
  double mean_own = 0;
  double mean_force = 0;
  for (const KnownPress& press : presses) {
    if (!with_offset) break;
    mean_own += press.own_force / count;
    mean_force += (press.force - press.air_force) / count;
  }
  double own_own = 0;
  double own_force = 0;
  double total = 0;
  for (const KnownPress& press : presses) {
    const double own = press.own_force - mean_own;
    own_own += own * own;
    own_force += own * (press.force - press.air_force - mean_force);
    total += press.own_force * press.own_force;
  }
  if (!(own_own > 1e-12 * total && std::isfinite(own_force))) {
    throw std::invalid_argument("contacts with a known force: accepted are different forces");
  }
  StiffnessFit fit;
  fit.stiffness = own_force / own_own;
  fit.offset = mean_force - fit.stiffness * mean_own;
  double squares = 0;
  for (const KnownPress& press : presses) {
    const double off = press.force - fit.stiffness * press.own_force - press.air_force - fit.offset;
    squares += off * off;
  }
  fit.scatter = std::sqrt(squares / count);
  fit.sigma_stiffness = std::sqrt(squares / (count - static_cast<double>(unknowns)) / own_own);
  return fit;
}

IdentifiedMembrane IdentifyMembrane(const MembraneShape& shape, double poisson_ratio,
                                    const MembranePress::Params& press,
                                    std::span<const PressSample> samples, bool with_offset) {
  IdentifiedMembrane identified;
  identified.tension_share = BestTensionShare(shape, poisson_ratio, press, samples);
  MembranePress best = MakePress(shape, poisson_ratio, identified.tension_share, press);
  identified.misfit = std::sqrt(MisfitOf(&best, samples).absolute);
  std::vector<KnownPress> known;
  for (const PressSample& sample : samples) {
    const auto& reading = best.Fit(sample.points_O);
    if (IsContact(reading)) {
      known.push_back({reading.own_force, reading.air_area * sample.pressure_rise, sample.force});
      ++identified.in_contact;
    } else if (with_offset) {
      known.push_back({0, 0, sample.force});
    }
  }
  identified.fit = FitStiffness(known, with_offset);
  identified.params = {.modulus = identified.fit.stiffness,
                       .poisson_ratio = poisson_ratio,
                       .tension = identified.tension_share * identified.fit.stiffness};
  return identified;
}

}  // namespace palpate
