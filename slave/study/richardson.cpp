#include "slave/study/richardson.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace palpate::study {
namespace {

constexpr double kMinRatio = 1.3, kWantedRatio = 2;
constexpr double kLowestOrder = 0.3, kHighestOrder = 6;
constexpr double kMinBar = 0.1, kBarOfThree = 1.0 / 3;

using Triple = std::array<MeshAnswer, 3>;  // finest first

// Selects from answers sorted by size the first and two coarser ones.
std::optional<Triple> TripleFrom(const std::vector<MeshAnswer>& sorted, std::size_t first) {
  Triple triple;
  if (first >= sorted.size()) return std::nullopt;
  triple[0] = sorted[first];
  for (std::size_t k = 1; k < 3; ++k) {
    const double finer = triple[k - 1].size;
    const MeshAnswer* best = nullptr;
    const auto badness = [&](const MeshAnswer& a) {
      return std::abs(std::log(a.size / finer / kWantedRatio));
    };
    for (const MeshAnswer& a : sorted) {
      if (a.size < kMinRatio * finer) continue;
      if (!best || badness(a) < badness(*best)) best = &a;
    }
    if (!best) return std::nullopt;
    triple[k] = *best;
  }
  return triple;
}

// Solves for p by bisection: the right-hand side of the equation decreases from its value at p -> 0
// to zero.
std::optional<double> OrderOf(const Triple& t) {
  const double fine = t[0].value - t[1].value, coarse = t[1].value - t[2].value;
  if (!(fine / coarse > 0)) return std::nullopt;
  const auto excess = [&](double p) {
    const double r1 = std::pow(t[0].size / t[1].size, p), r3 = std::pow(t[2].size / t[1].size, p);
    return (1 - r1) / (r3 - 1) - fine / coarse;
  };
  double low = kLowestOrder, high = kHighestOrder;
  if (!(excess(low) > 0 && excess(high) < 0)) return std::nullopt;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (excess(middle) > 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double LimitOf(const Triple& t, double order) {
  const double ratio = std::pow(t[1].size / t[0].size, order);
  return t[0].value + (t[0].value - t[1].value) / (ratio - 1);
}

double Spread(const Triple& t) {
  const auto [low, high] = std::minmax({t[0].value, t[1].value, t[2].value});
  return high - low;
}

// Sorts by size and keeps one answer per size.
void Sort(std::vector<MeshAnswer>* answers) {
  std::ranges::stable_sort(*answers, {}, &MeshAnswer::size);
  std::vector<MeshAnswer> unique;
  for (const MeshAnswer& a : *answers) {
    if (!unique.empty() && a.size <= unique.back().size * (1 + 1e-9)) unique.pop_back();
    unique.push_back(a);
  }
  *answers = std::move(unique);
}

}  // namespace

Extrapolation Extrapolate(std::vector<MeshAnswer> answers) {
  Sort(&answers);
  if (answers.size() < 2) return {};
  const MeshAnswer& finest = answers[0];
  const auto triple = TripleFrom(answers, 0);
  if (!triple) return {{finest.value, std::abs(finest.value - answers[1].value)}, kUnknown};
  const auto order = OrderOf(*triple);
  if (!order) return {{finest.value, Spread(*triple)}, kUnknown};
  const double limit = LimitOf(*triple, *order);
  const double step = std::abs(limit - finest.value);
  double bar = kBarOfThree * step;
  if (const auto coarser = TripleFrom(answers, 1)) {
    const auto coarser_order = OrderOf(*coarser);
    const double other = coarser_order ? LimitOf(*coarser, *coarser_order) : answers[1].value;
    bar = std::clamp(std::abs(limit - other), kMinBar * step, step);
  }
  return {{limit, bar}, *order};
}

}  // namespace palpate::study
