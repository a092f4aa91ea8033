// A Progress that remains valid after its listener is destroyed, for objects that store it.
#pragma once

#include "slave/program/progress.h"

namespace palpate {

// Forwards the progress of a precomputation to a listener, if there is one. Owned by the
// precomputed object.
class PrecomputeProgress final : public Progress {
 public:
  // `afterwards`: result of Report after Finish; false ends later searches at their first call.
  explicit PrecomputeProgress(bool afterwards) : afterwards_(afterwards) {}
  // Sets the listener and returns the progress for the precompute.
  Progress* Listen(Progress* listener) {
    listener_ = listener;
    return this;
  }
  // Ends the precompute and forgets the listener.
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
