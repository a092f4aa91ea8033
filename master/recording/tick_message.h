// TickRecord <-> palpate.v1.ForceTick.
#pragma once

#include "palpate/v1/recording.pb.h"

#include "master/haptics/tick_record.h"

namespace palpate {

// Overwrites `message`. Numbers keep seven digits.
void ToProto(const TickRecord& record, v1::ForceTick* message);
// Converts a message recorded `at`. Unknown additions of newer programs are ignored. Numbers that
// are not finite become zero.
TickRecord FromProto(const v1::ForceTick& message, Time at);

}  // namespace palpate
