#include "shared/wire/message_json.h"

#include <google/protobuf/util/json_util.h>

namespace palpate {

std::string JsonOf(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string json;
  const auto written = google::protobuf::util::MessageToJsonString(message, &json, options);
  return written.ok() ? json : std::string();
}

}  // namespace palpate
