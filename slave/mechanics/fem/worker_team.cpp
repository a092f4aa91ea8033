#include "slave/mechanics/fem/worker_team.h"

#include <algorithm>

namespace palpate::fem {

namespace {
constexpr int kWorthSharing = 64;  // indices; fewer cost less than waking a thread
}

WorkerTeam::WorkerTeam(int threads) {
  for (int i = 1; i < threads; ++i) threads_.emplace_back([this, i] { Serve(i); });
}

WorkerTeam::~WorkerTeam() {
  stopping_ = true;
  ++round_;
  round_.notify_all();
  for (auto& thread : threads_) thread.join();
}

void WorkerTeam::Run(int count, Call call, const void* work) noexcept {
  if (threads_.empty() || count < kWorthSharing) {
    call(work, 0, count);
    return;
  }
  count_ = count;
  call_ = call;
  work_ = work;
  busy_ = static_cast<int>(threads_.size());
  ++round_;
  round_.notify_all();
  DoShare(0);
  for (int left = busy_; left > 0; left = busy_) busy_.wait(left);
}

void WorkerTeam::DoShare(int worker) const noexcept {
  const int team = static_cast<int>(threads_.size()) + 1;
  const int share = (count_ + team - 1) / team;
  const int first = std::min(count_, worker * share);
  call_(work_, first, std::min(count_, first + share));
}

void WorkerTeam::Serve(int worker) noexcept {
  for (unsigned seen = 0;;) {
    round_.wait(seen);
    seen = round_;
    if (stopping_) return;
    DoShare(worker);
    if (--busy_ == 0) busy_.notify_one();
  }
}

}  // namespace palpate::fem
