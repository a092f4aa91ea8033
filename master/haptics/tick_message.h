// TickRecord <-> palpate.v1.ForceTick, the form of a tick for recording, page and log.
#pragma once

#include "palpate/v1/recording.pb.h"

#include "master/haptics/tick_record.h"

namespace palpate {

v1::OperatorPhase ToProto(OperatorState state);
v1::ForceReason ToProto(Reason reason);

// Overwrites `message`. Numbers keep seven digits. Numbers that are not finite are left out.
void ToProto(const TickRecord& record, v1::ForceTick* message);
// Converts a message recorded `at`. Unknown additions of newer programs are ignored. Numbers that
// are not finite become zero.
TickRecord FromProto(const v1::ForceTick& message, Time at);

}  // namespace palpate
