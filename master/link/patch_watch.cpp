#include "master/link/patch_watch.h"

#include "master/link/stream_keeper.h"
#include "shared/wire/patch_message.h"

namespace palpate {

struct PatchWatch::Parts {
  Parts(const SlaveLink::Options& link, LatestValue<ReceivedPatch>* target)
      : patches(target), stub(BulkStub(link)) {}

  // Why the message is rejected; empty: it is not.
  std::string Take(const v1::PatchUpdate& message);
  // Whether `message` was understood; `*reason` why not.
  bool Read(const v1::PatchUpdate& message, std::string* reason);

  LatestValue<ReceivedPatch>* const patches;
  const std::unique_ptr<v1::Teleoperation::Stub> stub;
  ReceivedPatch newest;              // used by the keeper's thread only
  std::uint32_t epoch_of_slave = 0;  // used by the keeper's thread only; 0: none of this stream yet

  mutable std::mutex mutex;  // guards what follows
  Stats received;            // without what the keeper counts
  StreamKeeper<v1::PatchUpdate> keeper{
      [this](grpc::ClientContext* context) {
        epoch_of_slave = 0;
        return stub->WatchPatch(context, {});
      },
      [this](v1::PatchUpdate* message) { return Take(*message); }};  // last: it uses all of these
};

std::string PatchWatch::Parts::Take(const v1::PatchUpdate& message) {
  std::string reason;
  const bool is_good = Read(message, &reason);
  if (is_good) patches->Put(newest);
  const std::scoped_lock lock(mutex);
  received.bytes += message.ByteSizeLong();
  if (!is_good) return "a patch was rejected: " + reason;
  ++(message.has_patch() ? received.patches : received.laws);
  return {};
}

bool PatchWatch::Parts::Read(const v1::PatchUpdate& message, std::string* reason) {
  auto law = FromProto(message.law(), reason);
  if (!law) return false;
  if (message.has_patch()) {
    const auto patch = FromProto(message.patch(), reason);
    if (!patch) return false;
    epoch_of_slave = patch->epoch;
    const std::uint32_t epoch = newest.patch.epoch + 1;
    newest.patch = *patch;
    newest.patch.epoch = epoch;
  }
  if (law->epoch != epoch_of_slave) {
    *reason = "law.epoch: accepted is that of the patch before";
    return false;
  }
  law->epoch = newest.patch.epoch;
  newest.law = *law;
  return true;
}

PatchWatch::PatchWatch(const SlaveLink::Options& link, LatestValue<ReceivedPatch>* patches)
    : parts_(std::make_unique<Parts>(link, patches)) {}

PatchWatch::~PatchWatch() = default;

PatchWatch::Stats PatchWatch::stats() const {
  const auto kept = parts_->keeper.stats();
  const std::scoped_lock lock(parts_->mutex);
  Stats stats = parts_->received;
  stats.refused = kept.rejected;
  stats.trouble = kept.trouble;
  return stats;
}

}  // namespace palpate
