#include "master/link/remote_patch.h"

#include "palpate/v1/patch.pb.h"

#include "shared/wire/patch_message.h"

namespace palpate {

const ReceivedPatch* PatchReader::Read(const v1::PatchUpdate& message, std::string* reason) {
  auto law = FromProto(message.law(), reason);
  if (!law) return nullptr;
  if (message.has_patch()) {
    const auto patch = FromProto(message.patch(), reason);
    if (!patch) return nullptr;
    epoch_of_slave_ = patch->epoch;
    const std::uint32_t epoch = newest_.patch.epoch + 1;
    newest_.patch = *patch;
    newest_.patch.epoch = epoch;
  }
  if (law->epoch != epoch_of_slave_) {
    *reason = "law.epoch: expected that of the patch before";
    return nullptr;
  }
  law->epoch = newest_.patch.epoch;
  newest_.law = *law;
  return &newest_;
}

}  // namespace palpate
