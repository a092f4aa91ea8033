#include "slave/tactile/training/estimate_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>

#include <Eigen/LU>

#include "shared/statistics/robust.h"

namespace palpate {
namespace {

std::vector<Eigen::Vector3f> EstimateAll(const ForceNetwork& network,
                                         const LabelledRecording& recording) {
  const std::unique_ptr<ForceEstimate> estimate = network.Windowed();
  std::vector<double> outputs(static_cast<std::size_t>(network.info().outputs));
  std::vector<Eigen::Vector3f> forces;
  forces.reserve(recording.change.size());
  for (const TactileSignals& change : recording.change) {
    if (estimate->Push(change, outputs)) {
      forces.push_back(Eigen::Vector3d(outputs[0], outputs[1], outputs[2]).cast<float>());
    } else {
      forces.push_back(Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
    }
  }
  return forces;
}

void CompareAxis(const Eigen::ArrayXd& estimated, const Eigen::ArrayXd& measured, Eigen::Index axis,
                 ForceErrors* errors) {
  const Eigen::ArrayXd error = estimated - measured;
  const Eigen::ArrayXd e = estimated - estimated.mean(), m = measured - measured.mean();
  const double mse = error.square().mean(), variance = m.square().mean();
  const double spread = std::sqrt(e.square().mean() * variance);
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  Eigen::Index at = 0;
  errors->peak[axis] = measured.abs().maxCoeff(&at);
  errors->at_peak[axis] = std::abs(error[at]);
  errors->worst[axis] = error.abs().maxCoeff();
  errors->rmse[axis] = std::sqrt(mse);
  errors->smse[axis] = variance > 0 ? mse / variance : kUnknown;
  errors->correlation[axis] = spread > 0 ? (e * m).mean() / spread : kUnknown;
}

Eigen::ArrayXd Axis(std::span<const Eigen::Vector3f> forces, Eigen::Index axis) {
  Eigen::ArrayXd values(static_cast<Eigen::Index>(forces.size()));
  for (std::size_t i = 0; i < forces.size(); ++i) {
    values[static_cast<Eigen::Index>(i)] = static_cast<double>(forces[i][axis]);
  }
  return values;
}

constexpr float kContactShare = 0.02F;  // of the largest force
constexpr double kWithin = 0.6827;      // share of the errors within one sigma
constexpr double kSameSizes = 1e-6;     // of forces whose sizes are taken for one

float LargestOf(std::span<const Eigen::Vector3f> forces) {
  float largest = 0;
  for (const Eigen::Vector3f& force : forces) largest = std::max(largest, force.norm());
  return largest;
}

// Of the errors' vectors, by the size of what was measured.
void CompareSizes(std::span<const Eigen::Vector3f> estimated,
                  std::span<const Eigen::Vector3f> measured, ForceErrors* errors) {
  const float least = kContactShare * LargestOf(measured);
  double squares_at_rest = 0;
  std::size_t at_rest = 0;
  ErrorLawFit in_contact;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const auto square = static_cast<double>((estimated[i] - measured[i]).squaredNorm());
    const float size = measured[i].norm();
    if (size > least) {
      in_contact.Take(square, static_cast<double>(size));
    } else if (!(size > 0)) {
      squares_at_rest += square;
      ++at_rest;
    }
  }
  if (at_rest > 0) errors->at_rest = std::sqrt(squares_at_rest / static_cast<double>(at_rest));
  errors->law = in_contact.law();
}

}  // namespace

// by_size = n growing + sizes relative^2, by_size2 = inverses growing + n relative^2.
ForceErrorLaw ErrorLawFit::ByMeans() const noexcept {
  double sizes = 0, inverses = 0, by_size = 0, by_size2 = 0;
  for (const auto& [square, size] : taken_) {
    sizes += size;
    inverses += 1 / size;
    by_size += square / size;
    by_size2 += square / (size * size);
  }
  const auto n = static_cast<double>(taken_.size());
  const double spread = sizes * inverses - n * n;
  const ForceErrorLaw all_relative{0, std::sqrt(by_size2 / n)};
  if (!(spread > kSameSizes * n * n)) return all_relative;
  const double growing = (sizes * by_size2 - n * by_size) / spread;
  const double relative2 = (inverses * by_size - n * by_size2) / spread;
  if (!(growing > 0)) return all_relative;
  if (!(relative2 > 0)) return {by_size / n, 0};
  return {growing, std::sqrt(relative2)};
}

ForceErrorLaw ErrorLawFit::law() const {
  if (taken_.empty()) return {};
  const ForceErrorLaw mean = ByMeans();
  if (!mean.known()) return {};
  std::vector<double> parts;
  parts.reserve(taken_.size());
  for (const auto& [square, size] : taken_) parts.push_back(std::sqrt(square) / mean.At(size));
  const auto count = static_cast<double>(parts.size());
  const auto within = parts.begin() + static_cast<std::ptrdiff_t>(kWithin * count);
  std::ranges::nth_element(parts, within);
  return {mean.growing * *within * *within, mean.relative * *within};
}

std::vector<Eigen::Vector3f> EstimateForces(const ForceNetwork& network,
                                            std::span<const LabelledRecording> recordings,
                                            std::span<const Window> windows) {
  std::vector<std::optional<std::vector<Eigen::Vector3f>>> all(recordings.size());
  std::vector<Eigen::Vector3f> forces;
  forces.reserve(windows.size());
  for (const Window& w : windows) {
    if (!all[w.recording]) all[w.recording] = EstimateAll(network, recordings[w.recording]);
    forces.push_back((*all[w.recording])[w.last]);
  }
  return forces;
}

std::vector<Eigen::Vector3f> MeasuredForces(std::span<const LabelledRecording> recordings,
                                            std::span<const Window> windows) {
  std::vector<Eigen::Vector3f> forces;
  forces.reserve(windows.size());
  for (const Window& w : windows) forces.push_back(recordings[w.recording].force[w.last]);
  return forces;
}

ForceErrors CompareForces(std::span<const Eigen::Vector3f> estimated,
                          std::span<const Eigen::Vector3f> measured) {
  ForceErrors errors;
  errors.count = measured.size();
  if (measured.empty()) return errors;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    CompareAxis(Axis(estimated, axis), Axis(measured, axis), axis, &errors);
  }
  CompareSizes(estimated, measured, &errors);
  return errors;
}

double FitForceGain(std::span<const Eigen::Vector3f> estimated,
                    std::span<const Eigen::Vector3f> measured) {
  double product = 0, square = 0;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const auto e = static_cast<double>(estimated[i].z()), m = static_cast<double>(measured[i].z());
    product += e * m;
    square += e * e;
  }
  const double gain = product / square;
  if (!(std::isfinite(gain) && gain > 0)) {
    throw std::invalid_argument(
        "no gain makes the network's fz that of the recording (" + std::to_string(gain) +
        "): accepted are contacts whose fz has the network's sign, force of the fingertip on the "
        "object");
  }
  return gain;
}

}  // namespace palpate
