// Domain enumerations <-> those of palpate/v1/state.proto. What a newer peer may have added is read
// as the most careful known value.
#pragma once

#include "palpate/v1/state.pb.h"

#include "shared/state/slave_state.h"
#include "shared/state/validity.h"

namespace palpate {

v1::Validity ToProto(Validity validity);
// Unknown and unspecified: kFailed.
Validity FromProto(v1::Validity validity);

v1::Phase ToProto(Phase phase);
// Unknown and unspecified: kHold, the tool stands.
Phase FromProto(v1::Phase phase);

v1::Event ToProto(Event event);
// Every known event of `events`, each once, in the order of the enumeration.
void ToProto(const Events& events, google::protobuf::RepeatedField<int>* message);
// Unknown and unspecified ones are left out.
Events FromProto(const google::protobuf::RepeatedField<int>& message);

}  // namespace palpate
