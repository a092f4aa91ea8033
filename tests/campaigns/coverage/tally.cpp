#include "tests/campaigns/coverage/tally.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <spdlog/fmt/fmt.h>

namespace palpate::coverage {

Bands BandsOf(const std::vector<EstimateRow>& rows) {
  Bands bands;
  bands.count = rows.size();
  if (rows.empty()) return bands;
  const auto mean = [&](const auto& of) {
    double sum = 0;
    for (const EstimateRow& one : rows) sum += of(one);
    return sum / static_cast<double>(rows.size());
  };
  // With a reported sigma of 0, only the exact true force counts as within it.
  const auto within = [&](double sigmas) {
    return mean(
        [&](const EstimateRow& t) { return std::abs(t.error) <= sigmas * t.sigma ? 1.0 : 0.0; });
  };
  const auto rms = [&](const auto& of) {
    return std::sqrt(mean([&](const EstimateRow& t) { return of(t) * of(t); }));
  };
  bands.one = within(1);
  bands.two = within(2);
  bands.z = rms([](const EstimateRow& t) { return t.sigma > 0 ? t.error / t.sigma : 0; });
  bands.z_vector = rms([](const EstimateRow& t) { return t.sigma > 0 ? t.off / t.sigma : 0; });
  bands.error = rms([](const EstimateRow& t) { return t.error; });
  bands.material = rms([](const EstimateRow& t) { return t.material; });
  bands.rest = rms([](const EstimateRow& t) { return t.error - t.material; });
  std::vector<double> sigmas;
  for (const EstimateRow& one : rows) sigmas.push_back(one.sigma);
  std::ranges::nth_element(sigmas, sigmas.begin() + std::ssize(sigmas) / 2);
  bands.sigma = sigmas[sigmas.size() / 2];
  return bands;
}

Intervals IntervalsOf(const std::vector<std::vector<EstimateRow>>& presses) {
  constexpr int kSeries = 2000;
  // Number of values outside of the interval at either end.
  constexpr std::size_t kOutside = kSeries / 40;
  struct Counts {
    double all = 0, one = 0, two = 0;
  };
  std::vector<Counts> counts;
  for (const auto& press : presses) {
    const Bands bands = BandsOf(press);
    const auto all = static_cast<double>(bands.count);
    if (all > 0) counts.push_back({all, all * bands.one, all * bands.two});
  }
  if (counts.empty()) return {};
  std::mt19937 random(1);
  std::uniform_int_distribution<std::size_t> draw(0, counts.size() - 1);
  std::vector<double> one, two;
  for (int i = 0; i < kSeries; ++i) {
    Counts sum;
    for (std::size_t k = 0; k < counts.size(); ++k) {
      const Counts& press = counts[draw(random)];
      sum = {sum.all + press.all, sum.one + press.one, sum.two + press.two};
    }
    one.push_back(sum.one / sum.all);
    two.push_back(sum.two / sum.all);
  }
  const auto middle = [](std::vector<double> shares) {
    std::ranges::sort(shares);
    return Interval{shares[kOutside], shares[shares.size() - 1 - kOutside]};
  };
  return {middle(one), middle(two)};
}

std::string Headline() {
  return fmt::format("{:<26}{:>6}{:>9}{:>9}{:>8}{:>8}{:>9}{:>9}{:>10}{:>8}", "", "n", "1 sigma",
                     "2 sigma", "z", "z vec", "sigma%", "error%", "material%", "rest%");
}

std::string InWords(const std::string& name, const Bands& b) {
  return fmt::format(
      "{:<26}{:>6}{:>8.1f}%{:>8.1f}%{:>8.2f}{:>8.2f}{:>9.2f}{:>9.2f}{:>10.2f}{:>8.2f}", name,
      b.count, 100 * b.one, 100 * b.two, b.z, b.z_vector, 100 * b.sigma, 100 * b.error,
      100 * b.material, 100 * b.rest);
}

}  // namespace palpate::coverage
