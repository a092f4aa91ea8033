// Networks that turn a fingertip's signals into the contact force (paper B, III.A.1, figure 6).
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include <Eigen/Core>

#include "slave/tactile/signals/rest_values.h"
#include "slave/tactile/signals/signal_pattern.h"

namespace palpate {

// Properties of a network.
struct NetworkInfo {
  std::string architecture;  // rnn_21 rnn_19 dnn_21 dnn_19 tnn_21 tnn_19
  int inputs = 0;            // 21: E1 to E19, pac0, pdc; 19: the electrodes alone
  int window = 1;            // window size in samples, the present one included
  int outputs = 0;    // the first three are the force of the fingertip on the object, frame F [N]
  double rate = 100;  // of the samples it was trained on [Hz]
  double gain = 1;    // its outputs are multiplied by it
  Eigen::Vector3d sigma{0, 0, 0};  // rms error on contacts not trained on [N]; 0: not known
  double rest_sigma = 0;           // one sigma of the force vector without contact [N]
  ForceErrorLaw error;             // additional sigma in contact
  double learnt_force = 0;         // largest |force| it was trained on [N]; 0: not known
  SignalPattern pattern;           // of the signals it was trained on
  std::string origin;              // origin of the network, one clause
};

// One fingertip's force, sample by sample. Allocation-free.
class ForceEstimate {
 public:
  virtual ~ForceEstimate() = default;
  ForceEstimate() = default;
  ForceEstimate(const ForceEstimate&) = delete;
  ForceEstimate& operator=(const ForceEstimate&) = delete;
  // Clears the window.
  virtual void Reset() noexcept = 0;
  // Processes the next sample, counts minus baseline. True: the window is full and `outputs` are
  // set (outputs.size() == NetworkInfo::outputs, gain applied). Not finite samples: false, and the
  // window starts again.
  virtual bool Push(const TactileSignals& change, std::span<double> outputs) noexcept = 0;
};

// Immutable; its estimators may run in several threads.
class ForceNetwork {
 public:
  virtual ~ForceNetwork() = default;
  ForceNetwork() = default;
  ForceNetwork(const ForceNetwork&) = delete;
  ForceNetwork& operator=(const ForceNetwork&) = delete;
  [[nodiscard]] virtual const NetworkInfo& info() const = 0;
  // The network evaluated over exactly the last `window` samples, from a state of zero; tnn_*: over
  // all since Reset, from the `window`-th on.
  [[nodiscard]] virtual std::unique_ptr<ForceEstimate> Windowed() const = 0;
};

// Loads a folder with `network.json`. Throws std::runtime_error naming the file and the error:
// missing, another format, unreadable, a tensor of the wrong shape (which, expected), a number that
// is not finite.
std::unique_ptr<ForceNetwork> LoadForceNetwork(const std::filesystem::path& path);

}  // namespace palpate
