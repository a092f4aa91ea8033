// Whether the model that is shown is worth more than the last force held: judged by what the slave
// then felt at the places that the hand had been shown a force for.
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

namespace palpate {

// Remembers what was shown at each tick and, once the slave tells what it felt when it did what was
// commanded then, compares the model's word of that tick, and that of holding, with it. A delay
// makes this late and changes nothing else.
//
// Some senses feel late, as a network over a window does: the model is right if what it said is
// felt within kLag. And no model is right to the last: what is within kTolerated of the force is.
// So a model goes that says what is never felt. Real-time safe; one thread.
class RenderFallbackSelector {
 public:
  static constexpr double kMemory = 0.5;  // of a sample of contact, to 1 / e [s]
  static constexpr double kWorse = 1.5;   // mean square over hold's, from which it is not chosen
  static constexpr double kEnough = 8;    // samples before a word is said
  static constexpr double kLag = 0.6;     // [s]
  static constexpr double kTolerated = 0.25;  // of the force [-]

  // At `now` [s] the model says `model`, and the newest force is `held` [N].
  void Show(double now, const Eigen::Vector3d& model, const Eigen::Vector3d& held) noexcept;
  // What was commanded at `commanded` [s] felt like `felt`, one standard deviation `sigma` [N]. By
  // how much more than the model said then [N]; zero where that is not remembered.
  Eigen::Vector3d Compare(double commanded, const Eigen::Vector3d& felt, double sigma) noexcept;
  [[nodiscard]] bool prefers_hold() const noexcept { return prefers_hold_; }

 private:
  struct Shown {
    double at = 0;
    Eigen::Vector3f model{0, 0, 0}, held{0, 0, 0};
  };
  struct Sample {
    double at = 0;
    Eigen::Vector3d model{0, 0, 0};
    double of_model = 0, of_hold = 0;  // errors [N], the model's the least so far
  };
  static constexpr std::size_t kTicks = 8192;  // round trips up to 8 s
  static constexpr std::size_t kWaiting = 512;
  [[nodiscard]] const Shown* Find(double at) const noexcept;
  void Count(const Sample& sample) noexcept;

  std::array<Shown, kTicks> shown_{};
  std::size_t count_ = 0;  // ever shown
  std::array<Sample, kWaiting> waiting_{};
  std::size_t first_ = 0, end_ = 0;                 // of those that wait for kLag to pass, ever
  double of_model_ = 0, of_hold_ = 0, weight_ = 0;  // sums of squares, of samples
  double last_ = 0;                                 // sample counted [s]
  bool prefers_hold_ = false;
};

}  // namespace palpate
