#include "shared/wire/enum_names.h"

#include <algorithm>
#include <string_view>

namespace palpate {

std::string ProtoNameOf(const google::protobuf::EnumValueDescriptor& value) {
  constexpr std::string_view kFirst = "UNSPECIFIED";
  std::string name = value.name().substr(value.type()->value(0)->name().size() - kFirst.size());
  std::ranges::transform(name, name.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return name;
}

}  // namespace palpate
