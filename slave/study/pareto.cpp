#include "slave/study/pareto.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace palpate::study {
namespace {

constexpr double kAsFast = 2;

bool IsComparable(const StudyRow& row) {
  return row.outcome == Outcome::kAnswered && std::isfinite(row.error.value) &&
         std::isfinite(row.update_median_s);
}

bool Beats(const StudyRow& a, const StudyRow& b) {
  return a.error.value <= b.error.value && a.update_median_s <= b.update_median_s &&
         (a.error.value < b.error.value || a.update_median_s < b.update_median_s);
}

template <typename Allowed, typename Cost>
StudyRow* Least(std::vector<StudyRow>* rows, const Allowed& allowed, const Cost& cost) {
  StudyRow* best = nullptr;
  for (StudyRow& row : *rows) {
    if (!IsComparable(row) || !allowed(row)) continue;
    if (!best || cost(row) < cost(*best)) best = &row;
  }
  return best;
}

std::string Sentence(const StudyRow& row, const char* because) {
  char numbers[160];
  std::snprintf(numbers, sizeof numbers, "%.2g %% error, %.3g us an update, %.2g s of precompute",
                100 * row.error.value, 1e6 * row.update_median_s, row.precompute_s);
  return row.family + ", " + row.resolution + ": " + because + " (" + numbers + ")";
}

}  // namespace

void MarkFront(std::vector<StudyRow>* rows) {
  for (StudyRow& row : *rows) {
    row.on_front = IsComparable(row) && std::ranges::none_of(*rows, [&](const StudyRow& other) {
                     return IsComparable(other) && Beats(other, row);
                   });
  }
}

std::string Recommend(double tolerance, double rate, std::vector<StudyRow>* rows) {
  for (StudyRow& row : *rows) {
    row.meets_tolerance = IsComparable(row) && row.error.value <= tolerance;
    row.meets_rate = IsComparable(row) && row.update_p99_s * rate <= 1;
    row.recommended = false;
  }
  const auto meets_both = [](const StudyRow& row) { return row.meets_tolerance && row.meets_rate; };
  const auto update = [](const StudyRow& row) { return row.update_median_s; };
  const auto miss = [&](const StudyRow& row) {
    return std::max(row.error.value / tolerance, row.update_p99_s * rate);
  };
  StudyRow* choice = nullptr;
  const char* because = "the cheapest that meets tolerance and rate";
  if (const StudyRow* fastest = Least(rows, meets_both, update)) {
    const double slowest = kAsFast * fastest->update_median_s;
    choice = Least(
        rows,
        [&](const StudyRow& row) { return meets_both(row) && row.update_median_s <= slowest; },
        [](const StudyRow& row) { return row.precompute_s; });
  } else {
    choice = Least(
        rows, [](const StudyRow&) { return true; }, miss);
    because = "none meets tolerance and rate; this one misses by the smallest factor";
  }
  if (!choice) return "no model answered with a known error";
  choice->recommended = true;
  return Sentence(*choice, because);
}

}  // namespace palpate::study
