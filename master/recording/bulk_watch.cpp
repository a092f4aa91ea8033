#include "master/recording/bulk_watch.h"

#include <condition_variable>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include <grpcpp/client_context.h>
#include <grpcpp/support/sync_stream.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/link/channel.h"

namespace palpate {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstRetry(200), kLongestRetry(2000), kHealthEvery(1000), kDeadline(1000);

}  // namespace

struct BulkWatch::Parts {
  Parts(const Options& options, OnMessage told)
      : on_message(std::move(told)),
        stub(v1::Teleoperation::NewStub(
            OpenChannel(PermittedTarget(options.target, options.insecure || !options.tls.empty()),
                        Traffic::kBulk, options.tls))) {}

  // Sleeps for `duration`; false: it is over.
  bool Sleep(milliseconds duration) {
    std::unique_lock lock(mutex);
    return !changed.wait_for(lock, duration, [this] { return stopping; });
  }
  // A context that the end cancels.
  class Call {
   public:
    explicit Call(Parts* parts) : parts_(*parts) {
      const std::scoped_lock lock(parts_.mutex);
      parts_.calls.insert(&context);
      if (parts_.stopping) context.TryCancel();
    }
    ~Call() {
      const std::scoped_lock lock(parts_.mutex);
      parts_.calls.erase(&context);
    }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

    grpc::ClientContext context;

   private:
    Parts& parts_;
  };

  // Streams of `Message`, one after the other. Ends where the slave has none of them.
  template <class Message, class Open>
  void Watch(const Open& open);
  // Queries the scene once per revision, and the status.
  void PollEverySecond();
  void RequestScene();

  const OnMessage on_message;
  const std::unique_ptr<v1::Teleoperation::Stub> stub;
  std::uint32_t revision = 0;  // of the last scene; used by the query thread only
  bool is_told = false;        // used by the query thread only

  std::mutex mutex;  // guards what follows
  std::condition_variable changed;
  bool stopping = false;
  std::set<grpc::ClientContext*> calls;

  std::jthread pictures, meshes, traces, health;  // last: they use all of the above
};

template <class Message, class Open>
void BulkWatch::Parts::Watch(const Open& open) {
  Backoff backoff(kFirstRetry, kLongestRetry);
  do {
    Call call(this);
    const auto stream = open(&call.context);
    Message message;
    while (stream->Read(&message)) {
      on_message(message);
      backoff.Reset();
    }
    const auto code = stream->Finish().error_code();
    if (code == grpc::StatusCode::FAILED_PRECONDITION || code == grpc::StatusCode::UNIMPLEMENTED) {
      return;
    }
  } while (Sleep(backoff.Next()));
}

void BulkWatch::Parts::RequestScene() {
  Call for_scene(this), for_capabilities(this);
  for_scene.context.set_deadline(std::chrono::system_clock::now() + kDeadline);
  for_capabilities.context.set_deadline(std::chrono::system_clock::now() + kDeadline);
  v1::SceneDescription scene;
  v1::Capabilities capabilities;
  if (!stub->GetScene(&for_scene.context, {}, &scene).ok()) return;
  if (std::exchange(is_told, true) && scene.settings_revision() == revision) return;
  revision = scene.settings_revision();
  on_message(scene);
  if (!stub->GetCapabilities(&for_capabilities.context, {}, &capabilities).ok()) return;
  on_message(capabilities);
}

void BulkWatch::Parts::PollEverySecond() {
  do {
    RequestScene();
    Call call(this);
    call.context.set_deadline(std::chrono::system_clock::now() + kDeadline);
    v1::Status status;
    if (stub->GetStatus(&call.context, {}, &status).ok()) on_message(status);
  } while (Sleep(kHealthEvery));
}

BulkWatch::BulkWatch(const Options& options, OnMessage on_message)
    : parts_(std::make_unique<Parts>(options, std::move(on_message))) {
  Parts* parts = parts_.get();
  parts->health = std::jthread([parts] { parts->PollEverySecond(); });
  parts->pictures = std::jthread([parts] {
    v1::WatchVideoRequest request;
    request.set_max_rate_hz(kPictureRate);
    request.set_quality(kQuality);
    parts->Watch<v1::VideoFrame>(
        [&](grpc::ClientContext* context) { return parts->stub->WatchVideo(context, request); });
  });
  parts->meshes = std::jthread([parts] {
    v1::WatchMeshRequest request;
    request.set_max_rate_hz(kMeshRate);
    request.set_traction(true);
    parts->Watch<v1::MeshState>(
        [&](grpc::ClientContext* context) { return parts->stub->WatchMesh(context, request); });
  });
  parts->traces = std::jthread([parts] {
    parts->Watch<v1::TraceUpdate>(
        [&](grpc::ClientContext* context) { return parts->stub->WatchTrace(context, {}); });
  });
}

BulkWatch::~BulkWatch() {
  {
    const std::scoped_lock lock(parts_->mutex);
    parts_->stopping = true;
    for (grpc::ClientContext* context : parts_->calls) context->TryCancel();
  }
  parts_->changed.notify_all();
}

}  // namespace palpate
