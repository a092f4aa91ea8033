#include "shared/wire/enums.h"

namespace palpate {

static_assert(static_cast<int>(Event::kContact) == v1::EVENT_CONTACT);
static_assert(static_cast<int>(Event::kCommandRefused) == v1::EVENT_COMMAND_REFUSED);
static_assert(static_cast<int>(Event::kCommandRefused) == v1::Event_MAX);
static_assert(static_cast<int>(Phase::kReady) == v1::PHASE_READY);
static_assert(static_cast<int>(Phase::kEstop) == v1::PHASE_ESTOP);
static_assert(static_cast<int>(Phase::kEstop) == v1::Phase_MAX);

v1::Validity ToProto(Validity validity) {
  switch (validity) {
    case Validity::kValid:
      return v1::VALIDITY_VALID;
    case Validity::kExtrapolated:
      return v1::VALIDITY_EXTRAPOLATED;
    case Validity::kPunctured:
      return v1::VALIDITY_PUNCTURED;
    case Validity::kStale:
      return v1::VALIDITY_STALE;
    case Validity::kTrackingLost:
      return v1::VALIDITY_TRACKING_LOST;
    case Validity::kFailed:
      break;
  }
  return v1::VALIDITY_FAILED;
}

Validity FromProto(v1::Validity validity) {
  switch (validity) {
    case v1::VALIDITY_VALID:
      return Validity::kValid;
    case v1::VALIDITY_EXTRAPOLATED:
      return Validity::kExtrapolated;
    case v1::VALIDITY_PUNCTURED:
      return Validity::kPunctured;
    case v1::VALIDITY_STALE:
      return Validity::kStale;
    case v1::VALIDITY_TRACKING_LOST:
      return Validity::kTrackingLost;
    default:
      return Validity::kFailed;
  }
}

v1::Phase ToProto(Phase phase) {
  return static_cast<v1::Phase>(phase);
}

Phase FromProto(v1::Phase phase) {
  if (phase < v1::PHASE_READY || phase > v1::PHASE_ESTOP) return Phase::kHold;
  return static_cast<Phase>(phase);
}

v1::Event ToProto(Event event) {
  return static_cast<v1::Event>(event);
}

void ToProto(const Events& events, google::protobuf::RepeatedField<int>* message) {
  message->Clear();
  if (events.empty()) return;
  for (int event = v1::EVENT_CONTACT; event <= v1::Event_MAX; ++event) {
    if (events.Has(static_cast<Event>(event))) message->Add(event);
  }
}

Events FromProto(const google::protobuf::RepeatedField<int>& message) {
  Events events;
  for (const int event : message) {
    if (event >= v1::EVENT_CONTACT && event <= v1::Event_MAX) events.Add(static_cast<Event>(event));
  }
  return events;
}

}  // namespace palpate
