// Names of enumerations in tables, metrics and logs: those that proto declares, so that a new value
// needs no second list.
#pragma once

#include <string>

#include <google/protobuf/descriptor.h>

namespace palpate {

// Returns the name in lower case and without the prefix of the enumeration: `following` for
// PHASE_FOLLOWING. The prefix is that of the first value, which is PREFIX_UNSPECIFIED.
std::string ProtoNameOf(const google::protobuf::EnumValueDescriptor& value);

}  // namespace palpate
