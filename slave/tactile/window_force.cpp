#include "slave/tactile/window_force.h"

#include <algorithm>
#include <cmath>

#include "slave/tactile/network/network_weights.h"

namespace palpate {
namespace {

// Error of networks of electrodes that do not state it: paper B, table I, rnn_21 [N].
const Eigen::Vector3d kPaperSigma{0.01807, 0.03107, 0.05171};
constexpr double kLag = 3;  // typical delay of a recurrent network's answer [samples]
// Delay of other networks [samples]. [measured: the shipped one on three foams, presses at 20 to
// 100 mm/s: 0.10 to 0.35]
constexpr double kPromptLag = 0.25;
constexpr double kLeap = 0.5;  // share of a sudden change that may be an error

}  // namespace

WindowForce::WindowForce(const ForceNetwork* network) {
  if (network == nullptr) return;
  network_ = network->info();
  if (!(network_.sigma.norm() > 0)) network_.sigma = kPaperSigma;
  outputs_.resize(static_cast<std::size_t>(network_.outputs));
  estimate_ = network->Windowed();
}

void WindowForce::Reset() noexcept {
  if (estimate_) estimate_->Reset();
  pace_F_.setZero();
}

// Interpolates `missed` samples linearly between their neighbours.
void WindowForce::Bridge(const TactileSignals& change, int missed) noexcept {
  for (int k = 1; k <= missed; ++k) {
    const double share = static_cast<double>(k) / (missed + 1);
    TactileSignals between = change;
    for (std::size_t i = 0; i < between.size(); ++i) {
      between[i] = last_[i] + share * (change[i] - last_[i]);
    }
    Push(between);
  }
}

std::optional<Eigen::Vector3d> WindowForce::ForceOf(const TactileSignals& change) noexcept {
  if (!estimate_) return std::nullopt;
  estimate_->Reset();
  bool is_full = false;
  for (int k = 0; k < network_.window; ++k) is_full = Push(change);
  estimate_->Reset();
  if (!is_full) return std::nullopt;
  return Eigen::Vector3d(outputs_[0], outputs_[1], outputs_[2]);
}

WindowForce::Estimate WindowForce::Take(const TactileSignals& change, bool is_full,
                                        const std::optional<Eigen::Vector3d>& before_F,
                                        const SignalModel* signals) noexcept {
  last_ = change;
  contact_F_.reset();
  if (!is_full) return {};
  const Eigen::Vector3d force_F(outputs_[0], outputs_[1], outputs_[2]);
  if (!force_F.allFinite()) return {};
  if (network_.gives_contact_point) contact_F_.emplace(outputs_[3], outputs_[4], outputs_[5]);
  step_ = before_F ? (force_F - *before_F).norm() : 0;
  leap_ = before_F ? (force_F - *before_F - pace_F_).norm() : 0;
  if (before_F) pace_F_ += kBriskly * (force_F - *before_F - pace_F_);
  const double sigma = SigmaOf(force_F, signals);
  if (signals == nullptr) return {force_F, sigma};
  const double gain_sigma = signals->noise().gain_sigma() * force_F.norm();
  return {force_F, std::hypot(sigma, signals->force_sigma(), gain_sigma)};
}

// Returns the sigma of a force. Beyond the training it grows with the force, and always with the
// rate of the force. If no error law is known, the error along the force is used; components with
// an unknown error get the largest known one.
double WindowForce::SigmaOf(const Eigen::Vector3d& force_F,
                            const SignalModel* signals) const noexcept {
  const double size = force_F.norm(), largest = network_.sigma.maxCoeff();
  if (network_.error.known()) {
    const double lag = IsRecurrent(network_.architecture) ? kLag : kPromptLag;
    const ForceErrorLaw of_kind =
        signals != nullptr ? network_.pattern.kinds[signals->kind()].error : ForceErrorLaw{};
    const double learnt = (of_kind.known() ? of_kind : network_.error).At(size);
    // The training contains changing forces, too: only the excess over that change counts.
    const double changing = std::hypot(lag * pace_F_.norm(), kLeap * leap_);
    return std::hypot(network_.rest_sigma, std::max(learnt, changing));
  }
  const Eigen::Vector3d sigma_F = (network_.sigma.array() > 0).select(network_.sigma, largest);
  const double sigma = size > 0 ? force_F.cwiseProduct(sigma_F).norm() / size : largest;
  return network_.learnt_force > 0 ? sigma * std::max(1.0, size / network_.learnt_force) : sigma;
}

}  // namespace palpate
