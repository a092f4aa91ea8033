// How many may watch at once: each watching stream holds a thread.
#pragma once

#include <algorithm>
#include <atomic>
#include <string>

#include <grpcpp/support/status.h>

namespace palpate {

class ObserverSeats {
 public:
  static constexpr int kSeats = 64;

  // A seat, given back at the end of its scope. Empty if all were taken.
  class Seat {
   public:
    explicit Seat(ObserverSeats* seats)
        : seats_(seats), seated_(seats->taken_.fetch_add(1) < kSeats) {}
    ~Seat() { --seats_->taken_; }
    Seat(const Seat&) = delete;
    Seat& operator=(const Seat&) = delete;
    explicit operator bool() const { return seated_; }

   private:
    ObserverSeats* seats_;
    bool seated_;
  };

  [[nodiscard]] int taken() const { return std::min(taken_.load(), kSeats); }
  static grpc::Status Full() {
    return {grpc::StatusCode::RESOURCE_EXHAUSTED,
            std::to_string(kSeats) + " streams are watched already: no more are served"};
  }

 private:
  std::atomic<int> taken_{0};
};

}  // namespace palpate
