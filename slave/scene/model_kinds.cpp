#include "slave/scene/model_kinds.h"

#include <algorithm>

namespace palpate {

const ModelKind* FindModelKind(std::string_view name) {
  const auto* found = std::ranges::find(kModelKinds, name, &ModelKind::name);
  return found == kModelKinds.end() ? nullptr : found;
}

ObjectClass ClassOf(const Geometry& geometry) {
  if (IsVolume(geometry)) return ObjectClass::kVolume;
  return IsPlanar(geometry) ? ObjectClass::kOutline : ObjectClass::kMembrane;
}

bool IsKindFor(ObjectClass object, std::string_view kind) {
  const ModelKind* found = FindModelKind(kind);
  return kind == "auto" || (found != nullptr && found->object == object);
}

std::string KindsFor(ObjectClass object) {
  std::string words = "auto";
  std::string_view last;
  for (const ModelKind& kind : kModelKinds) {
    if (kind.object != object) continue;
    if (!last.empty()) words.append(", ").append(last);
    last = kind.name;
  }
  return words.append(" or ").append(last);
}

}  // namespace palpate
