#include "slave/mechanics/fem/search_progress.h"

#include <algorithm>
#include <cmath>

namespace palpate::fem {
namespace {

constexpr std::chrono::milliseconds kBetween{100};

}  // namespace

void SearchProgress::Begin() noexcept {
  stopped_ = false;
  first_ = 0;
  done_ = 0;
  if (progress_ != nullptr) told_ = Clock::now();
}

void SearchProgress::Reach(double residual, double target) noexcept {
  if (progress_ == nullptr || !(residual > 0) || !(target > 0)) return;
  first_ = std::max(first_, residual);
  const double digits = std::log(first_ / target);
  if (digits > 0) done_ = std::max(done_, std::clamp(std::log(first_ / residual) / digits, 0., 1.));
}

bool SearchProgress::Tell(const char* stage, double done) noexcept {
  if (progress_ == nullptr || stopped_) return !stopped_;
  const auto now = Clock::now();
  if (now - told_ < kBetween) return true;
  told_ = now;
  try {
    stopped_ = !progress_->Report(stage, done);
  } catch (...) {  // a search is not worth less for not being told of
  }
  return !stopped_;
}

}  // namespace palpate::fem
