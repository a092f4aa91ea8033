#include "master/recording/bulk_watch.h"

#include <utility>

#include "master/link/stream_keeper.h"

namespace palpate {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kHealthEvery(1000);

v1::WatchVideoRequest PictureRequest() {
  v1::WatchVideoRequest request;
  request.set_max_rate_hz(BulkWatch::kPictureRate);
  request.set_quality(BulkWatch::kQuality);
  return request;
}

v1::WatchMeshRequest MeshRequest() {
  v1::WatchMeshRequest request;
  request.set_max_rate_hz(BulkWatch::kMeshRate);
  request.set_traction(true);
  return request;
}

}  // namespace

struct BulkWatch::Parts {
  Parts(const SlaveLink::Options& link, OnMessage told)
      : on_message(std::move(told)), stub(BulkStub(link)) {}

  // Queries the scene once per revision, and the status.
  void PollEverySecond(const std::stop_token& stop);
  void RequestScene(const std::stop_token& stop);
  std::string Take(const google::protobuf::Message& message) const {
    on_message(message);
    return {};
  }

  const OnMessage on_message;
  const std::unique_ptr<v1::Teleoperation::Stub> stub;
  std::uint32_t revision = 0;  // of the last scene; used by the query thread only
  bool is_told = false;        // used by the query thread only

  std::mutex mutex;  // of the wait
  std::condition_variable_any stopped;

  // Last: they use all of the above.
  StreamKeeper<v1::VideoFrame> pictures{
      [this](grpc::ClientContext* context) { return stub->WatchVideo(context, PictureRequest()); },
      [this](v1::VideoFrame* frame) { return Take(*frame); }};
  StreamKeeper<v1::MeshState> meshes{
      [this](grpc::ClientContext* context) { return stub->WatchMesh(context, MeshRequest()); },
      [this](v1::MeshState* mesh) { return Take(*mesh); }};
  StreamKeeper<v1::TraceUpdate> traces{
      [this](grpc::ClientContext* context) { return stub->WatchTrace(context, {}); },
      [this](v1::TraceUpdate* update) { return Take(*update); }};
  std::jthread health{[this](const std::stop_token& stop) { PollEverySecond(stop); }};
};

void BulkWatch::Parts::RequestScene(const std::stop_token& stop) {
  using Stub = v1::Teleoperation::Stub;
  v1::SceneDescription scene;
  v1::Capabilities capabilities;
  if (!Query(stub.get(), &Stub::GetScene, stop, &scene).ok()) return;
  if (std::exchange(is_told, true) && scene.settings_revision() == revision) return;
  revision = scene.settings_revision();
  on_message(scene);
  if (Query(stub.get(), &Stub::GetCapabilities, stop, &capabilities).ok()) on_message(capabilities);
}

void BulkWatch::Parts::PollEverySecond(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    RequestScene(stop);
    v1::Status status;
    if (Query(stub.get(), &v1::Teleoperation::Stub::GetStatus, stop, &status).ok())
      on_message(status);
    std::unique_lock lock(mutex);
    stopped.wait_for(lock, stop, kHealthEvery, [] { return false; });
  }
}

BulkWatch::BulkWatch(const SlaveLink::Options& link, OnMessage on_message)
    : parts_(std::make_unique<Parts>(link, std::move(on_message))) {}

BulkWatch::~BulkWatch() = default;

}  // namespace palpate
