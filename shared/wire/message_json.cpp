#include "shared/wire/message_json.h"

#include <string_view>

#include <google/protobuf/util/json_util.h>

namespace palpate {
namespace {

// Protobuf prints numbers that are not finite as texts. A page would join them to numbers as text.
void MakeNotFiniteNull(std::string* json) {
  for (const std::string_view text : {"\"NaN\"", "\"Infinity\"", "\"-Infinity\""}) {
    for (std::size_t at = json->find(text); at != std::string::npos;
         at = json->find(text, at + 1)) {
      const std::size_t after = at + text.size();
      const bool is_value = at > 0 && std::string_view(":[,").find((*json)[at - 1]) < 3 &&
                            after < json->size() && (*json)[after] != ':';
      if (is_value) json->replace(at, text.size(), "null");
    }
  }
}

}  // namespace

std::string JsonOf(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string json;
  const auto written = google::protobuf::util::MessageToJsonString(message, &json, options);
  if (!written.ok()) return {};
  MakeNotFiniteNull(&json);
  return json;
}

}  // namespace palpate
