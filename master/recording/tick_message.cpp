#include "master/recording/tick_message.h"

#include <cmath>

#include "shared/wire/fields.h"

namespace palpate {
namespace {

Eigen::Vector3d FiniteOrZero(const v1::Vec3f& message) {
  const Eigen::Vector3d v(message.x(), message.y(), message.z());
  return v.allFinite() ? v : Eigen::Vector3d::Zero();
}

}  // namespace

void ToProto(const TickRecord& record, v1::ForceTick* message) {
  const ForceChain& chain = record.chain;
  message->Clear();
  ToProto(record.p_M, message->mutable_p_m());
  ToProto(record.p_S, message->mutable_p_s());
  if (chain.force_known) ToProto(chain.estimated, message->mutable_estimated());
  ToProto(chain.local, message->mutable_local());
  ToProto(chain.scaled, message->mutable_scaled());
  ToProto(chain.passive, message->mutable_passive());
  ToProto(chain.limited, message->mutable_limited());
  ToProto(chain.sent, message->mutable_sent());
  message->set_phase(static_cast<v1::OperatorPhase>(static_cast<int>(record.state) + 1));
  for (std::size_t i = 0; i < kReasonCount; ++i) {
    if (!chain.reasons.Has(static_cast<Reason>(i))) continue;
    message->add_reasons(static_cast<v1::ForceReason>(i + 1));
  }
  message->set_epoch(record.epoch);
  if (record.state_age >= 0) message->set_state_age(static_cast<float>(record.state_age));
  if (record.state_age >= 0) message->set_sensed_age(static_cast<float>(record.sensed_age));
  message->set_state_sequence(record.state_sequence);
  message->set_round_trip(static_cast<float>(record.round_trip));
  message->set_marks(record.marks);
  if (std::isfinite(record.energy)) message->set_energy(static_cast<float>(record.energy));
  if (!record.tare.isZero(0)) ToProto(record.tare, message->mutable_tare());
  if (!record.has_truth) return;
  ToProto(record.truth, message->mutable_true_force());
  ToProto(record.truth_at, message->mutable_true_at());
}

TickRecord FromProto(const v1::ForceTick& message, Time at) {
  TickRecord record;
  record.at = at;
  record.p_M = FiniteOrZero(message.p_m());
  record.p_S = FiniteOrZero(message.p_s());
  ForceChain& chain = record.chain;
  chain.force_known = message.has_estimated();
  chain.estimated = FiniteOrZero(message.estimated());
  chain.local = FiniteOrZero(message.local());
  chain.scaled = FiniteOrZero(message.scaled());
  chain.passive = FiniteOrZero(message.passive());
  chain.limited = FiniteOrZero(message.limited());
  chain.sent = FiniteOrZero(message.sent());
  const int phase = message.phase() - 1;
  if (phase >= 0 && phase < static_cast<int>(kOperatorStateCount)) {
    record.state = static_cast<OperatorState>(phase);
  }
  for (const int reason : message.reasons()) {
    if (reason < 1 || reason > static_cast<int>(kReasonCount)) continue;
    chain.reasons.Add(static_cast<Reason>(reason - 1));
  }
  record.epoch = message.epoch();
  if (message.has_state_age()) record.state_age = message.state_age();
  if (message.has_sensed_age()) record.sensed_age = message.sensed_age();
  record.state_sequence = message.state_sequence();
  record.round_trip = message.round_trip();
  record.marks = message.marks();
  record.energy = message.has_energy() ? message.energy() : std::nan("");
  record.tare = FiniteOrZero(message.tare());
  record.has_truth = message.has_true_force() && message.has_true_at();
  if (!record.has_truth) return record;
  std::string reason;
  record.truth = FiniteOrZero(message.true_force());
  record.truth_at = FieldReader(&reason).Stamp("true_at", message.true_at());
  return record;
}

}  // namespace palpate
