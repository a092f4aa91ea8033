// Messages as received from the peer: accepted values must be finite.
#include <stdexcept>
#include <string>

#include "palpate/v1/teleoperation.pb.h"

#include "shared/wire/patch_message.h"
#include "shared/wire/state_message.h"
#include "slave/service/messages.h"
#include "tests/fuzz/fuzz_files.h"

namespace palpate {
namespace {

template <class Message>
Message Parsed(std::string_view bytes) {
  Message message;
  static_cast<void>(message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())));
  return message;
}

void Read(std::size_t kind, std::string_view bytes) {
  std::string reason;
  switch (kind) {
    case 0: {
      const auto command = FromProto(Parsed<v1::OperatorCommand>(bytes), &reason);
      v1::OperatorCommand again;
      if (command) ToProto(*command, &again);
      // An accepted message survives another conversion.
      if (command && !FromProto(again, &reason)) std::abort();
      return;
    }
    case 1: {
      const auto state = FromProto(Parsed<v1::SlaveState>(bytes), &reason);
      v1::SlaveState again;
      if (state) ToProto(*state, &again);
      if (state && !FromProto(again, &reason)) std::abort();
      return;
    }
    case 2:
      FromProto(Parsed<v1::TactileSample>(bytes), &reason);
      return;
    case 3:
      ToChange(Parsed<v1::SetParametersRequest>(bytes));
      return;
    case 4:
      ToChange(Parsed<v1::SetModelRequest>(bytes));
      return;
    case 5: {
      const auto patch = FromProto(Parsed<v1::SurfacePatch>(bytes), &reason);
      v1::SurfacePatch again;
      if (patch) ToProto(*patch, &again);
      if (patch && !FromProto(again, &reason)) std::abort();
      return;
    }
    case 6: {
      const auto law = FromProto(Parsed<v1::PatchLaw>(bytes), &reason);
      v1::PatchLaw again;
      if (law) ToProto(*law, &again);
      if (law && !FromProto(again, &reason)) std::abort();
      return;
    }
    default:
      GapOf(Parsed<v1::WatchStateRequest>(bytes));
      QualityOf(Parsed<v1::WatchImagesRequest>(bytes));
  }
}

}  // namespace
}  // namespace palpate

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  const fuzz::Input input(data, size, 8);
  fuzz::Try<std::invalid_argument>([&] { Read(input.kind, input.bytes); });
  return 0;
}
