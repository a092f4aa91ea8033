// The local contact model as sent by the slave: checked PatchUpdates.
#pragma once

#include <cstdint>
#include <string>

#include "master/haptics/received.h"

namespace palpate {

namespace v1 {
class PatchUpdate;
}

// Reads the messages of WatchPatch streams in their order.
class PatchReader {
 public:
  // A new stream starts with a patch.
  void BeginStream() { epoch_of_slave_ = 0; }
  // The newest patch with its law, until the next call. Null: `message` is invalid; `*reason` says
  // why.
  const ReceivedPatch* Read(const v1::PatchUpdate& message, std::string* reason);

 private:
  ReceivedPatch newest_;
  std::uint32_t epoch_of_slave_ = 0;  // 0: no patch of this stream yet
};

}  // namespace palpate
