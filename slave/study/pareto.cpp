#include "slave/study/pareto.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace palpate {
namespace {

constexpr double kAsFast = 2;

bool IsComparable(const Row& row) {
  return row.outcome == Outcome::kAnswered && std::isfinite(row.error.value) &&
         std::isfinite(row.update_median_s);
}

bool Beats(const Row& a, const Row& b) {
  return a.error.value <= b.error.value && a.update_median_s <= b.update_median_s &&
         (a.error.value < b.error.value || a.update_median_s < b.update_median_s);
}

template <typename Allowed, typename Cost>
Row* Least(std::vector<Row>* rows, const Allowed& allowed, const Cost& cost) {
  Row* best = nullptr;
  for (Row& row : *rows) {
    if (!IsComparable(row) || !allowed(row)) continue;
    if (!best || cost(row) < cost(*best)) best = &row;
  }
  return best;
}

std::string Sentence(const Row& row, const char* because) {
  char numbers[160];
  std::snprintf(numbers, sizeof numbers, "%.2g %% error, %.3g us an update, %.2g s of precompute",
                100 * row.error.value, 1e6 * row.update_median_s, row.precompute_s);
  return row.family + ", " + row.resolution + ": " + because + " (" + numbers + ")";
}

}  // namespace

void MarkFront(std::vector<Row>* rows) {
  for (Row& row : *rows) {
    row.on_front = IsComparable(row) && std::ranges::none_of(*rows, [&](const Row& other) {
                     return IsComparable(other) && Beats(other, row);
                   });
  }
}

std::string Recommend(double tolerance, double rate, std::vector<Row>* rows) {
  for (Row& row : *rows) {
    row.meets_tolerance = IsComparable(row) && row.error.value <= tolerance;
    row.meets_rate = IsComparable(row) && row.update_p99_s * rate <= 1;
    row.recommended = false;
  }
  const auto meets_both = [](const Row& row) { return row.meets_tolerance && row.meets_rate; };
  const auto update = [](const Row& row) { return row.update_median_s; };
  const auto miss = [&](const Row& row) {
    return std::max(row.error.value / tolerance, row.update_p99_s * rate);
  };
  Row* choice = nullptr;
  const char* because = "the cheapest that meets tolerance and rate";
  if (const Row* fastest = Least(rows, meets_both, update)) {
    const double slowest = kAsFast * fastest->update_median_s;
    choice = Least(
        rows, [&](const Row& row) { return meets_both(row) && row.update_median_s <= slowest; },
        [](const Row& row) { return row.precompute_s; });
  } else {
    choice = Least(
        rows, [](const Row&) { return true; }, miss);
    because = "none meets tolerance and rate; this one misses by the smallest factor";
  }
  if (!choice) return "no model answered with a known error";
  choice->recommended = true;
  return Sentence(*choice, because);
}

}  // namespace palpate
