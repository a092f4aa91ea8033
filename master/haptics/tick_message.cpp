#include "master/haptics/tick_message.h"

#include <cmath>

#include "shared/wire/fields.h"
#include "shared/wire/message_fields.h"

namespace palpate {
namespace {

static_assert(kOperatorStateCount == v1::OperatorPhase_MAX);
static_assert(kReasonCount == v1::ForceReason_MAX);

OperatorState FromProto(v1::OperatorPhase phase) {
  const bool is_known = phase != v1::OPERATOR_PHASE_UNSPECIFIED && v1::OperatorPhase_IsValid(phase);
  return is_known ? static_cast<OperatorState>(phase - 1) : OperatorState::kDisconnected;
}

// Calls `field` for each field with its value and largest accepted magnitude. The same list serves
// for writing (const records) and for reading.
template <class Record, class Fields>
void VisitTick(Record& record, const Fields& field) {
  using M = v1::ForceTick;
  auto& chain = record.chain;
  field(M::kPMFieldNumber, record.p_M, kMaxLength, Presence::kWritten);
  field(M::kPSFieldNumber, record.p_S, kMaxLength, Presence::kWritten);
  field(M::kLocalFieldNumber, chain.local, kMaxForce, Presence::kWritten);
  field(M::kScaledFieldNumber, chain.scaled, kMaxForce, Presence::kWritten);
  field(M::kPassiveFieldNumber, chain.passive, kMaxForce, Presence::kWritten);
  field(M::kLimitedFieldNumber, chain.limited, kMaxForce, Presence::kWritten);
  field(M::kSentFieldNumber, chain.sent, kMaxForce, Presence::kWritten);
  field(M::kEpochFieldNumber, record.epoch);
  field(M::kStateSequenceFieldNumber, record.state_sequence);
  field(M::kRoundTripFieldNumber, record.round_trip, kMaxDelay);
  field(M::kMarksFieldNumber, record.marks);
  field(M::kTareFieldNumber, record.tare, kMaxForce);
  field(M::kTorqueFieldNumber, record.torque, kMaxMoment);
}

}  // namespace

v1::OperatorPhase ToProto(OperatorState state) {
  return static_cast<v1::OperatorPhase>(static_cast<int>(state) + 1);
}

v1::ForceReason ToProto(Reason reason) {
  return static_cast<v1::ForceReason>(static_cast<int>(reason) + 1);
}

void ToProto(const TickRecord& record, v1::ForceTick* message) {
  message->Clear();
  const MessageWriter field(message);
  VisitTick(record, field);
  message->set_phase(ToProto(record.state));
  const ForceChain& chain = record.chain;
  if (chain.force_known) ToProto(chain.estimated, message->mutable_estimated());
  for (std::size_t i = 0; i < kReasonCount; ++i) {
    const auto reason = static_cast<Reason>(i);
    if (chain.reasons.Has(reason)) message->add_reasons(ToProto(reason));
  }
  if (record.state_age >= 0) {
    message->set_state_age(static_cast<float>(record.state_age));
    message->set_sensed_age(static_cast<float>(record.sensed_age));
  }
  field(v1::ForceTick::kEnergyFieldNumber, record.energy, kMaxForce);
  if (!record.has_truth) return;
  ToProto(record.truth, message->mutable_true_force());
  ToProto(record.truth_at, message->mutable_true_at());
}

TickRecord FromProto(const v1::ForceTick& message, Time at) {
  std::string reason;
  FieldReader reader(&reason);
  TickRecord record;
  record.at = at;
  VisitTick(record, MessageReader(message, &reader));
  record.state = FromProto(message.phase());
  ForceChain& chain = record.chain;
  chain.force_known = message.has_estimated();
  chain.estimated = reader.Vector("estimated", message.estimated(), kMaxForce);
  for (const int sent : message.reasons()) {
    if (v1::ForceReason_IsValid(sent) && sent > 0) chain.reasons.Add(static_cast<Reason>(sent - 1));
  }
  if (message.has_state_age()) record.state_age = message.state_age();
  if (message.has_sensed_age()) record.sensed_age = message.sensed_age();
  record.energy = message.has_energy() ? message.energy() : std::nan("");
  record.has_truth = message.has_true_force() && message.has_true_at();
  if (!record.has_truth) return record;
  record.truth = reader.Vector("true_force", message.true_force(), kMaxForce);
  record.truth_at = reader.Stamp("true_at", message.true_at());
  return record;
}

}  // namespace palpate
