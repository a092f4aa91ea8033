#include "master/link/patch_watch.h"

#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include <grpcpp/client_context.h>
#include <grpcpp/support/sync_stream.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/link/channel.h"
#include "master/link/status_words.h"
#include "shared/wire/patch_message.h"

namespace palpate {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstRetry(100), kLongestRetry(2000);

}  // namespace

struct PatchWatch::Parts {
  Parts(const Options& options, LatestValue<ReceivedPatch>* target)
      : patches(target),
        stub(v1::Teleoperation::NewStub(
            OpenChannel(PermittedTarget(options.target, options.insecure || !options.tls.empty()),
                        Traffic::kBulk, options.tls, options.longest_round_trip))) {}

  void Run();
  // Reads one stream until its end. False: the slave does not support it.
  bool Watch();
  void Take(const v1::PatchUpdate& message);
  // Whether `message` was understood; `*reason` why not.
  bool Read(const v1::PatchUpdate& message, std::string* reason);

  LatestValue<ReceivedPatch>* const patches;
  const std::unique_ptr<v1::Teleoperation::Stub> stub;
  ReceivedPatch newest;              // used by the thread only
  std::uint32_t epoch_of_slave = 0;  // used by the thread only; 0: no patch of this stream yet

  mutable std::mutex mutex;  // guards what follows
  std::condition_variable stopped;
  bool stopping = false;
  grpc::ClientContext* context = nullptr;  // of the open stream
  Stats stats;

  std::jthread thread;  // last: it uses all of the above
};

void PatchWatch::Parts::Run() {
  Backoff backoff(kFirstRetry, kLongestRetry);
  while (Watch()) {
    if (epoch_of_slave != 0) backoff.Reset();
    std::unique_lock lock(mutex);
    if (stopped.wait_for(lock, backoff.Next(), [this] { return stopping; })) return;
  }
}

bool PatchWatch::Parts::Watch() {
  grpc::ClientContext own;
  {
    const std::scoped_lock lock(mutex);
    if (stopping) return false;
    context = &own;
  }
  epoch_of_slave = 0;
  const auto stream = stub->WatchPatch(&own, {});
  v1::PatchUpdate message;
  while (stream->Read(&message)) Take(message);
  const grpc::Status status = stream->Finish();
  const std::scoped_lock lock(mutex);
  context = nullptr;
  if (!stopping) {
    stats.trouble = status.ok() ? "the slave ended the stream" : WordsOf(status);
  }
  return status.error_code() != grpc::StatusCode::UNIMPLEMENTED;
}

void PatchWatch::Parts::Take(const v1::PatchUpdate& message) {
  std::string reason;
  const bool is_good = Read(message, &reason);
  if (is_good) patches->Put(newest);
  const std::scoped_lock lock(mutex);
  stats.bytes += message.ByteSizeLong();
  if (!is_good) {
    ++stats.refused;
    stats.trouble = "a patch was rejected: " + reason;
    return;
  }
  ++(message.has_patch() ? stats.patches : stats.laws);
  stats.trouble.clear();
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

PatchWatch::PatchWatch(const Options& options, LatestValue<ReceivedPatch>* patches)
    : parts_(std::make_unique<Parts>(options, patches)) {
  parts_->thread = std::jthread([parts = parts_.get()] { parts->Run(); });
}

PatchWatch::~PatchWatch() {
  Stop();
}

PatchWatch::Stats PatchWatch::stats() const {
  const std::scoped_lock lock(parts_->mutex);
  return parts_->stats;
}

void PatchWatch::Stop() {
  {
    const std::scoped_lock lock(parts_->mutex);
    parts_->stopping = true;
    if (parts_->context != nullptr) parts_->context->TryCancel();
  }
  parts_->stopped.notify_all();
  if (parts_->thread.joinable()) parts_->thread.join();
}

}  // namespace palpate
