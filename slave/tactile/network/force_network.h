// Networks that turn a fingertip's signals into the contact force (paper B, III.A.1, figure 6).
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include <Eigen/Core>

#include "slave/scene/options/tactile_channels.h"
#include "slave/tactile/signals/channel_pattern.h"
#include "slave/tactile/signals/signal_pattern.h"
#include "slave/tactile/signals/tactile_signals.h"

namespace palpate {

// An electrode that is constant for this time is faulty [s], because a working one has noise of
// about a count. The longest stretch in recordings at 100 Hz, fingers at rest and in contact, is
// 0.43 s of 52 s times 19 electrodes; 0.26 s and 0.12 s in others, 0.16 s in fifteen seconds of
// five fingers. A stretch of twice the length is a thousand times as rare.
inline constexpr double kConstant = 1;

// Properties of a network.
struct NetworkInfo {
  std::string architecture;  // rnn_N dnn_N tnn_N, N inputs
  int inputs = 0;            // the channels; 21: E1 to E19, pac0, pdc
  int window = 1;            // window size in samples, the present one included
  TactileChannels channels;  // of the sensor
  double noise = 1;          // rms of a channel at rest [unit of the channels]
  // A channel that stays the same for longer is dead [s]; 0: it may.
  double longest_constant = kConstant;
  bool gives_contact_point = false;  // outputs 4 to 6, on the sensor's surface, frame F [m]
  int outputs = 0;    // the first three are the force of the fingertip on the object, frame F [N]
  double rate = 100;  // of the samples it was trained on [Hz]
  double gain = 1;    // factor on its outputs
  Eigen::Vector3d sigma{0, 0, 0};  // rms error on contacts outside of the training [N]; 0: unknown
  double rest_sigma = 0;           // one sigma of the force vector without contact [N]
  ForceErrorLaw error;             // additional sigma in contact
  double learnt_force = 0;         // largest |force| of the training [N]; 0: unknown
  SignalPattern pattern;           // of the signals it was trained on
  // Pattern of a sensor without electrodes; null: unknown.
  std::shared_ptr<const ChannelPattern> channel_pattern;
  // Growth of the force error by drift since the baseline [N/s]; 0: unknown.
  double drift = 0;
  std::string origin;  // origin of the network, one clause
};

// ForceEstimate estimates the force of one fingertip, sample by sample, without allocation.
class ForceEstimate {
 public:
  virtual ~ForceEstimate() = default;
  ForceEstimate() = default;
  ForceEstimate(const ForceEstimate&) = delete;
  ForceEstimate& operator=(const ForceEstimate&) = delete;
  // Clears the window.
  virtual void Reset() noexcept = 0;
  // Processes the next sample, counts minus baseline. True: the window is full and `outputs` are
  // set (outputs.size() == NetworkInfo::outputs, gain applied). A sample that is not finite returns
  // false and restarts the window.
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
