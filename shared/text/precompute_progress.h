// What is made may go on asking the progress it was made with, whose listener is gone by then.
#pragma once

#include "shared/text/progress.h"

namespace palpate {

// Stands between a precompute and its `listener` (null: none), and is owned by what is made.
class PrecomputeProgress final : public Progress {
 public:
  // `afterwards`: what Report answers once it is made; false: searches end when they first ask.
  explicit PrecomputeProgress(bool afterwards) : afterwards_(afterwards) {}
  // For the precompute.
  Progress* Listen(Progress* listener) {
    listener_ = listener;
    return this;
  }
  // It is made: nobody listens any more.
  void Finish() { listener_ = nullptr, is_made_ = true; }

  void Expect(const PrecomputeCost& cost) override {
    if (listener_ != nullptr) listener_->Expect(cost);
  }
  bool Report(std::string_view stage, double done) override {
    if (is_made_) return afterwards_;
    return listener_ == nullptr || listener_->Report(stage, done);
  }

 private:
  const bool afterwards_;
  bool is_made_ = false;
  Progress* listener_ = nullptr;
};

}  // namespace palpate
