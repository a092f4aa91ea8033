#include "shared/wire/trace_message.h"

#include <algorithm>

#include "shared/wire/fields.h"

namespace palpate {

void ToProto(const SampleTrace& trace, v1::SampleTrace* message) {
  message->Clear();
  message->set_sample(trace.sample);
  ToProto(trace.sensed_at, message->mutable_sensed_at());
  const auto since = [&trace](Time at) {
    return at < trace.sensed_at ? 0 : Narrow(SecondsBetween(trace.sensed_at, at));
  };
  message->set_acquired(since(trace.acquired_at));
  message->set_processed(std::max(message->acquired(), since(trace.processed_at)));
  message->set_solved(std::max(message->processed(), since(trace.solved_at)));
}

std::optional<SampleTrace> FromProto(const v1::SampleTrace& message, std::string* reason) {
  FieldReader reader(reason);
  reader.Require(message.has_sensed_at(), "sensed_at is absent", "a time");
  if (!reader.ok()) return std::nullopt;
  SampleTrace trace;
  trace.sample = message.sample();
  trace.sensed_at = reader.Stamp("sensed_at", message.sensed_at());
  const auto at = [&](const char* name, float value) {
    return trace.sensed_at + Seconds(reader.NonNegative(name, value, kMaxDelay));
  };
  trace.acquired_at = at("acquired", message.acquired());
  trace.processed_at = at("processed", message.processed());
  trace.solved_at = at("solved", message.solved());
  if (!reader.ok()) return std::nullopt;
  return trace;
}

}  // namespace palpate
