#include "master/session/tick_summary.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

constexpr double kMinForce = 1e-12;  // [N]
constexpr double kStep = 1.01;

int BinOf(double force, int bins) {
  if (!(force > kMinForce)) return 0;
  return static_cast<int>(std::min(std::log(force / kMinForce) / std::log(kStep), bins - 1.0));
}

// Fraction of the peak force above which a tick counts as contact.
constexpr double kContactShare = 0.01;
constexpr std::uint64_t kLeft = 50;  // ticks without force that end a contact
constexpr double kGivesWay =
    0.9;  // share of the rendered force below which the membrane may be broken
constexpr std::size_t kSoon = 200;  // ticks in which a puncture would be reported

}  // namespace

void ForceError::Add(const Eigen::Vector3d& local, const Eigen::Vector3d& truth) noexcept {
  const double error = (local - truth).norm();
  Bin& bin = bins_[static_cast<std::size_t>(BinOf(std::max(local.norm(), truth.norm()), kBins))];
  bin.sum_of_squares += error * error;
  bin.peak = std::max(bin.peak, error);
  ++bin.ticks;
  ++count_;
}

ForceError::Summary ForceError::Above(double threshold) const noexcept {
  Summary summary;
  double sum = 0;
  for (int i = BinOf(threshold, kBins) + 1; i < kBins; ++i) {
    const Bin& bin = bins_[static_cast<std::size_t>(i)];
    sum += bin.sum_of_squares;
    summary.peak = std::max(summary.peak, bin.peak);
    summary.ticks += bin.ticks;
  }
  if (summary.ticks > 0) summary.rms = std::sqrt(sum / static_cast<double>(summary.ticks));
  return summary;
}

void BreakingError::Add(const Eigen::Vector3d& local, const Eigen::Vector3d& truth, bool punctured,
                        ForceError* contact) {
  if (punctured && !punctured_) {
    ++punctures_;
    breaking_ = waiting_.size();
    for (const auto& [shown, was] : waiting_) error_.Add(shown, was);
    waiting_.clear();
  }
  punctured_ = punctured;
  if (punctured && !local.isZero(0)) {
    max_ticks_ = std::max(max_ticks_, ++breaking_);
    return error_.Add(local, truth);
  }
  if (!punctured && truth.norm() < kGivesWay * local.norm()) {
    if (waiting_.size() == kSoon) Close(contact);
    waiting_.emplace_back(local, truth);
    return;
  }
  Close(contact);
  contact->Add(local, truth);
}

void BreakingError::Close(ForceError* contact) {
  for (const auto& [shown, was] : waiting_) contact->Add(shown, was);
  waiting_.clear();
}

void TickSummary::Add(const TickRecord& record, const std::optional<Eigen::Vector3d>& truth) {
  const ForceChain& chain = record.chain;
  if (truth) {
    breaking_.Add(chain.local, *truth, chain.reasons.Has(Reason::kPunctured), &error_);
    if (record.state != OperatorState::kFollowing && chain.local.isZero(0)) {
      let_go_.Add(chain.local, *truth);
    }
  }
  if (chain.force_known) estimated_peak_ = std::max(estimated_peak_, chain.estimated.norm());
  sent_peak_ = std::max(sent_peak_, chain.sent.norm());
  for (std::size_t i = 0; i < kReasonCount; ++i) {
    if (chain.reasons.Has(static_cast<Reason>(i))) ++reason_ticks_[i];
  }
  if (record.state_age >= 0 && chain.reasons.Has(Reason::kStale)) ++stale_ticks_;
  ++state_ticks_[static_cast<std::size_t>(record.state)];
  epochs_ = std::max(epochs_, record.epoch);
  AddFingers(record);
}

void TickSummary::AddDelayCompensated(const TickRecord& record,
                                      const std::optional<Eigen::Vector3d>& truth) {
  if (!truth || record.state != OperatorState::kFollowing) return;
  const double size = std::max(record.chain.local.norm(), truth->norm());
  delay_compensated_peak_ = std::max(delay_compensated_peak_, size);
  const bool touches = size > kMinForce && size > kContactShare * delay_compensated_peak_;
  if (touches && contact_ == Contact::kNone) contact_ = Contact::kFirst;
  free_ticks_ = touches ? 0 : free_ticks_ + 1;
  if (contact_ == Contact::kFirst && free_ticks_ > kLeft) contact_ = Contact::kLater;
  breaking_delay_compensated_.Add(
      record.chain.local, *truth, record.chain.reasons.Has(Reason::kPunctured),
      contact_ == Contact::kLater ? &delay_compensated_ : &first_contact_);
}

void TickSummary::Close() {
  breaking_.Close(&error_);
  breaking_delay_compensated_.Close(contact_ == Contact::kLater ? &delay_compensated_
                                                                : &first_contact_);
}

void TickSummary::AddFingers(const TickRecord& record) noexcept {
  const auto count = static_cast<std::size_t>(record.finger_count);
  finger_count_ = std::max(finger_count_, count);
  for (std::size_t i = 0; i < count; ++i) {
    const FingerState& state = record.fingers[i];
    FingerSummary& finger = fingers_[i];
    ++finger.ticks;
    if (state.in_contact) ++finger.contact_ticks;
    if (!IsForceKnown(state)) continue;
    finger.force_peak = std::max(finger.force_peak, state.force->cast<double>().norm());
  }
}

void TickSummary::AddTruth(const Eigen::Vector3d& truth) noexcept {
  has_truth_ = true;
  truth_peak_ = std::max(truth_peak_, truth.norm());
}

std::optional<TickSummary::DelayCompensated> TickSummary::force_error_delay_compensated()
    const noexcept {
  if (first_contact_.empty()) return std::nullopt;
  const double threshold = kContactShare * force_peak();
  return DelayCompensated{delay_compensated_.Above(threshold), first_contact_.Above(threshold)};
}

std::optional<TickSummary::Breaking> TickSummary::breaking() const noexcept {
  if (breaking_.punctures() == 0) return std::nullopt;
  return Breaking{breaking_.error().Above(kContactShare * force_peak()), breaking_.punctures(),
                  breaking_.longest()};
}

std::optional<ForceError::Summary> TickSummary::force_error() const noexcept {
  if (error_.empty()) return std::nullopt;
  return error_.Above(kContactShare * force_peak());
}

std::uint64_t TickSummary::let_go_ticks() const noexcept {
  return let_go_.Above(kContactShare * force_peak()).ticks;
}

}  // namespace palpate
