// TickRecord <-> palpate.v1.ForceTick.
#pragma once

#include "palpate/v1/recording.pb.h"

#include "master/haptics/record/tick_record.h"

namespace palpate {

// Overwrites `message`. Numbers keep seven digits.
void ToProto(const TickRecord& record, v1::ForceTick* message);
// As it was recorded `at`. What a newer program may have added is left out; numbers that are not
// finite are zero.
TickRecord FromProto(const v1::ForceTick& message, Time at);

}  // namespace palpate
