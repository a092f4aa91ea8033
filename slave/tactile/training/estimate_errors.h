// Errors of networks on recordings with known forces (paper B, table I).
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "slave/tactile/network/force_network.h"
#include "slave/tactile/recordings/labelled_recording.h"
#include "slave/tactile/signals/rest_values.h"
#include "slave/tactile/signals/signal_pattern.h"

namespace palpate {

// The force at the windows' ends [N]: the exact windowed evaluation, sample by sample through every
// recording from its start. NaN before the network's window is full.
std::vector<Eigen::Vector3f> EstimateForces(const ForceNetwork& network,
                                            std::span<const LabelledRecording> recordings,
                                            std::span<const Window> windows);
// The measured force there [N].
std::vector<Eigen::Vector3f> MeasuredForces(std::span<const LabelledRecording> recordings,
                                            std::span<const Window> windows);

// How good force estimates are. Per axis, frame F.
struct ForceErrors {
  std::size_t count = 0;
  Eigen::Vector3d rmse{0, 0, 0};  // [N]
  Eigen::Vector3d smse{
      0, 0, 0};  // mean squared error / variance of the measured values; NaN: no variation
  Eigen::Vector3d correlation{0, 0, 0};  // NaN: one of them did not vary
  Eigen::Vector3d peak{0, 0, 0};         // largest |measured| [N]
  Eigen::Vector3d at_peak{0, 0, 0};      // |error| at that instant [N]
  Eigen::Vector3d worst{0, 0, 0};        // largest |error| [N]
  double at_rest = 0;  // of the vector, rms, where nothing was measured [N]; 0: no such sample
  ForceErrorLaw law;   // from a fiftieth of the largest force on
};

// Fits ForceErrorLaw: how it grows by the mean squares in parts of |f| and of |f|^2, how large it
// is by the share of the errors that lie within it.
class ErrorLawFit {
 public:
  // For one sample the squared error [N^2] and the magnitude of the force [N], > 0. Values that are
  // not finite are not used: the window was not full.
  void Take(double square, double size) {
    if (std::isfinite(square)) taken_.push_back({square, size});
  }
  [[nodiscard]] ForceErrorLaw law() const;  // not known: nothing was taken
  [[nodiscard]] std::size_t count() const noexcept { return taken_.size(); }

 private:
  struct Sample {
    double square, size;
  };
  [[nodiscard]] ForceErrorLaw ByMeans() const noexcept;

  std::vector<Sample> taken_;
};

// `estimated` and `measured` have the same length, [N]. Empty ones give count 0.
ForceErrors CompareForces(std::span<const Eigen::Vector3f> estimated,
                          std::span<const Eigen::Vector3f> measured);

// The gain that adapts a known network to another fingertip: g that makes g fz_estimated closest to
// fz_measured, least squares through the origin. Throws std::invalid_argument: no data, not finite,
// or not positive (for example the force of the object on the fingertip).
double FitForceGain(std::span<const Eigen::Vector3f> estimated,
                    std::span<const Eigen::Vector3f> measured);

}  // namespace palpate
