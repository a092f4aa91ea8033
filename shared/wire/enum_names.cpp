#include "shared/wire/enum_names.h"

#include <algorithm>
#include <string_view>

#include "shared/wire/fields.h"

namespace palpate {

std::string ProtoNameOf(const google::protobuf::EnumValueDescriptor& value) {
  constexpr std::string_view kFirst = "UNSPECIFIED";
  std::string name = value.name().substr(value.type()->value(0)->name().size() - kFirst.size());
  std::ranges::transform(name, name.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return name;
}

std::vector<std::string> ProtoNamesOf(const google::protobuf::EnumDescriptor& enumeration) {
  std::vector<std::string> names;
  for (int number = 0; number < enumeration.value_count(); ++number) {
    names.push_back(ProtoNameOf(*enumeration.FindValueByNumber(number)));
  }
  return names;
}

std::string_view ToString(Validity validity) {
  return ProtoNameOf(ToProto(validity));
}

std::string_view ToString(FailedCheck check) {
  return check == FailedCheck::kNone ? std::string_view() : ProtoNameOf(ToProto(check));
}

}  // namespace palpate
