// Names of enumerations in tables and logs: those that proto declares, so that a new value
// needs no second list.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <google/protobuf/descriptor.h>
#include <google/protobuf/generated_enum_reflection.h>

#include "shared/state/failed_check.h"
#include "shared/state/validity.h"

namespace palpate {

// Returns the name in lower case and without the prefix of the enumeration: `following` for
// PHASE_FOLLOWING. The prefix is that of the first value, which is PREFIX_UNSPECIFIED.
std::string ProtoNameOf(const google::protobuf::EnumValueDescriptor& value);
// Returns these names indexed by the value's number, from 0 without gaps.
std::vector<std::string> ProtoNamesOf(const google::protobuf::EnumDescriptor& enumeration);
// The name of `value`, which has one, with static lifetime.
template <class ProtoEnum>
requires google::protobuf::is_proto_enum<ProtoEnum>::value std::string_view ProtoNameOf(
    ProtoEnum value) {
  static const std::vector<std::string> names =
      ProtoNamesOf(*google::protobuf::GetEnumDescriptor<ProtoEnum>());
  return names.at(static_cast<std::size_t>(value));
}

// Names in tables and CSV files: `valid`; `model_range`, or empty for kNone. Static lifetime.
std::string_view ToString(Validity validity);
std::string_view ToString(FailedCheck check);

}  // namespace palpate
