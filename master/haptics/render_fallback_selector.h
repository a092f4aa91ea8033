// Selects the held force while the local model is worse, by comparison with the forces that the
// slave reports later for the same commanded positions.
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

namespace palpate {

// Stores the model force and the held force of each tick. When the slave reports its estimate for
// the command of that tick, both are compared with it. A delay only postpones the comparison.
//
// Some sensors respond late, such as a neural network over a window: the model is correct if its
// force is estimated within kLag. Errors below kTolerated of the force are accepted. A model whose
// force is never confirmed is dropped. Real-time safe. Not thread-safe.
class RenderFallbackSelector {
 public:
  static constexpr double kMemory = 0.5;  // time constant of the weight of a contact sample [s]
  static constexpr double kWorse = 1.5;   // ratio of mean squares (model / hold) that selects hold
  static constexpr double kEnough = 8;    // samples before a decision
  static constexpr double kLag = 0.6;     // [s]
  static constexpr double kTolerated = 0.25;  // of the force [-]

  // Stores the force of the model and the held force [N] at `now` [s].
  void Show(double now, const Eigen::Vector3d& model, const Eigen::Vector3d& held) noexcept;
  // Compares with the force `estimated`, of standard deviation `sigma` [N], for the command of
  // `commanded` [s]. Returns the estimate minus the model force [N]; zero if that tick is not
  // stored.
  Eigen::Vector3d Compare(double commanded, const Eigen::Vector3d& estimated,
                          double sigma) noexcept;
  [[nodiscard]] bool prefers_hold() const noexcept { return prefers_hold_; }

 private:
  struct Shown {
    double at = 0;
    Eigen::Vector3f model{0, 0, 0}, held{0, 0, 0};
  };
  struct Sample {
    double at = 0;
    Eigen::Vector3d model{0, 0, 0};
    double of_model = 0, of_hold = 0;  // errors [N]; of the model: the least so far
  };
  static constexpr std::size_t kTicks = 8192;  // round trips up to 8 s
  static constexpr std::size_t kWaiting = 512;
  [[nodiscard]] const Shown* Find(double at) const noexcept;
  void Count(const Sample& sample) noexcept;

  std::array<Shown, kTicks> shown_{};
  std::size_t count_ = 0;  // total number stored
  std::array<Sample, kWaiting> waiting_{};
  std::size_t first_ = 0, end_ = 0;                 // total numbers of samples that wait for kLag
  double of_model_ = 0, of_hold_ = 0, weight_ = 0;  // weighted sums of squares, and of samples
  double last_ = 0;                                 // time of the last counted sample [s]
  bool prefers_hold_ = false;
};

}  // namespace palpate
