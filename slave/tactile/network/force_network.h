// Networks that turn a fingertip's signals into the contact force (paper B, III.A.1, figure 6).
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include <Eigen/Core>

#include "slave/tactile/rest_values.h"
#include "slave/tactile/signal_pattern.h"

namespace palpate {

// What a network says of itself.
struct NetworkInfo {
  std::string architecture;  // rnn_21 rnn_19 dnn_21 dnn_19 tnn_21 tnn_19 or onnx
  int inputs = 0;            // 21: E1 to E19, pac0, pdc; 19: the electrodes alone
  int window = 1;            // samples it looks back over, this one included
  int outputs = 0;    // the first three are the force of the fingertip on the object, frame F [N]
  double rate = 100;  // of the samples it was trained on [Hz]
  double gain = 1;    // its outputs are multiplied by it
  Eigen::Vector3d sigma{0, 0, 0};  // rms error on contacts not trained on [N]; 0: not known
  double rest_sigma = 0;           // likewise of the vector, where nothing touches [N]
  ForceErrorLaw error;             // and where something does, besides
  double learnt_force = 0;         // largest |force| it was trained on [N]; 0: not known
  SignalPattern pattern;           // of the signals it was trained on
  std::string origin;              // where it comes from, one clause
};

// One fingertip's force, sample by sample. Allocation-free.
class ForceEstimate {
 public:
  virtual ~ForceEstimate() = default;
  ForceEstimate() = default;
  ForceEstimate(const ForceEstimate&) = delete;
  ForceEstimate& operator=(const ForceEstimate&) = delete;
  // Forgets what was seen.
  virtual void Reset() noexcept = 0;
  // Takes the next sample, counts minus rest. True: the window is full and `outputs` are set
  // (outputs.size() == NetworkInfo::outputs, gain applied). Not finite samples: false, and the
  // window starts anew.
  virtual bool Push(const TactileSignals& change, std::span<double> outputs) noexcept = 0;
};

// Immutable; estimates of it may live in several threads.
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
  // Whether there is a state to carry on.
  [[nodiscard]] virtual bool HasState() const { return false; }
  // The state is carried on from sample to sample instead: cheaper, and another function. Networks
  // without a state: the same as Windowed.
  [[nodiscard]] virtual std::unique_ptr<ForceEstimate> CarryingState() const = 0;
};

// A folder with palpate's `network.json`, a folder in the layout in which the authors' weights
// survive (`tensors.json`), or an ONNX file. Throws std::runtime_error naming the file and what is
// wrong: missing, not readable, a tensor of the wrong shape (which, expected), a number that is not
// finite, an ONNX operator that is not supported (its name).
std::unique_ptr<ForceNetwork> LoadForceNetwork(const std::filesystem::path& path);

}  // namespace palpate
