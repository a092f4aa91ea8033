// Messages as JSON, for pages.
#pragma once

#include <string>

#include <google/protobuf/message.h>

namespace palpate {

// `message` with the field names of proto/palpate/v1 and the names of enumerations; empty if that
// fails. Numbers that are zero are printed, absent ones are not. Numbers that are not finite are
// null, and so are texts that read like them: "NaN", "Infinity", "-Infinity".
std::string JsonOf(const google::protobuf::Message& message);

}  // namespace palpate
