#include "slave/checks/consistency.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "slave/checks/chi_square.h"

namespace palpate {
namespace {

// Square that a residual counts for at most [-]. [by definition: over the gate of any window, and
// finite]
constexpr double kMaxSquare = 1e6;

}  // namespace

Consistency::Consistency(int window) : window_(static_cast<std::size_t>(window)) {
  assert(window >= 1 && window <= kMaxWindow);
}

Consistency::Window* Consistency::FindWindow(FailedCheck code) noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    if (windows_[i].code == code) return &windows_[i];
  }
  assert(count_ < windows_.size());
  if (count_ == windows_.size()) return nullptr;
  windows_[count_] = Window();
  windows_[count_].code = code;
  return &windows_[count_++];
}

void Consistency::Add(const Residual& residual) noexcept {
  Window* window = FindWindow(residual.code);
  if (window == nullptr) return;
  const double ratio = residual.value / residual.sigma;
  const bool is_usable = std::isfinite(ratio) && residual.sigma > 0;
  const double square = is_usable ? std::min(ratio * ratio, kMaxSquare) : kMaxSquare;
  Sum& sum = window->sums[now_];
  if (sum.n == 0 || square > window->largest) {
    window->largest = square;
    window->reason = residual.reason;
  }
  sum.q += square;
  ++sum.n;
}

Consistency::Sum Consistency::Total(const Window& window) const noexcept {
  Sum total;
  for (std::size_t i = 0; i < window_; ++i) {
    total.q += window.sums[i].q;
    total.n += window.sums[i].n;
  }
  return total;
}

Consistency::Result Consistency::Close() noexcept {
  Result result;
  double worst = 1;
  for (std::size_t i = 0; i < count_; ++i) {
    const Sum total = Total(windows_[i]);
    if (total.n == 0) continue;
    const double excess = total.q / ChiSquareGate(total.n);
    if (excess <= 1) result.widening = std::max(result.widening, std::sqrt(total.q / total.n));
    if (!(excess > worst)) continue;
    worst = excess;
    result.verdict = {Validity::kExtrapolated, windows_[i].code, windows_[i].reason};
  }
  now_ = (now_ + 1) % window_;
  for (std::size_t i = 0; i < count_; ++i) windows_[i].sums[now_] = {};
  return result;
}

void Consistency::Reset() noexcept {
  now_ = count_ = 0;
}

}  // namespace palpate
