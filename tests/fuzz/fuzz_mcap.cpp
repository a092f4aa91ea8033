// Recordings: any bytes as a file, any bytes as the records of a chunk, and messages of both
// programs.
#include <cmath>
#include <cstdlib>
#include <string>

#include "palpate/v1/recording.pb.h"

#include "master/recording/session_recording.h"
#include "shared/recording/mcap_reader.h"
#include "shared/text/text.h"
#include "slave/recording/step_messages.h"
#include "tests/fuzz/fuzz_files.h"

namespace palpate {
namespace {

void ReadFile(std::string_view bytes) {
  McapReader reader(fuzz::Write("a.mcap", bytes));
  for (McapMessage message; reader.Next(&message);) {
    if (reader.channel(message.channel) == nullptr) std::abort();
  }
  if (!reader.is_whole() && bytes.size() > kMcapMagic.size() && reader.damage().size() > 10000) {
    std::abort();
  }
}

std::string FileOfChunk(std::string_view records) {
  std::string chunk, file(kMcapMagic);
  McapPacker(&chunk).Add(std::uint64_t{0}).Add(std::uint64_t{0});
  McapPacker(&chunk).Add(static_cast<std::uint64_t>(records.size())).Add(std::uint32_t{0});
  McapPacker(&chunk).Add(std::string_view()).AddBytes(records);
  McapPacker(&file).AddRecord(McapRecord::kChunk, chunk);
  return file;
}

void Read(std::size_t kind, std::string_view bytes) {
  switch (kind) {
    case 0:
      return ReadFile(bytes);
    case 1:
      return ReadFile(FileOfChunk(bytes));
    case 2: {
      v1::TactileInstant message;
      if (message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) FromProto(message);
      return;
    }
    default: {
      v1::ForceTick message;
      if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return;
      const TickRecord tick = FromProto(message, {});
      if (!tick.chain.sent.allFinite() || !tick.p_M.allFinite()) std::abort();
    }
  }
}

}  // namespace
}  // namespace palpate

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  const fuzz::Input input(data, size, 4);
  fuzz::Try<InputError>([&] { Read(input.kind, input.bytes); });
  return 0;
}
