#include "master/link/mesh_watch.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include <grpcpp/client_context.h>
#include <grpcpp/support/sync_stream.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/link/channel.h"
#include "master/link/status_words.h"

namespace palpate {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstRetry(100), kLongestRetry(2000);

v1::WatchMeshRequest Request(const MeshWatch::Options& options) {
  v1::WatchMeshRequest request;
  request.set_max_rate_hz(options.rate);
  request.set_nodal_forces(options.nodal_forces);
  request.set_relative_error(options.relative_error);
  request.set_traction(options.traction);
  return request;
}

}  // namespace

struct MeshWatch::Parts {
  explicit Parts(const Options& options)
      : request(Request(options)),
        stub(v1::Teleoperation::NewStub(
            OpenChannel(PermittedTarget(options.target, options.insecure || !options.tls.empty()),
                        Traffic::kBulk, options.tls, options.longest_round_trip))) {}

  void Run();
  // Reads one stream until its end. True: a mesh was received.
  bool Watch();
  void Take(v1::MeshState* message, MeshReader* reader);

  const v1::WatchMeshRequest request;
  const std::unique_ptr<v1::Teleoperation::Stub> stub;

  mutable std::mutex mutex;  // guards what follows
  std::condition_variable stopped;
  bool stopping = false;
  grpc::ClientContext* context = nullptr;  // of the open stream
  std::shared_ptr<const RemoteMesh> newest;
  Stats stats;

  std::jthread thread;  // last: it uses all of the above
};

void MeshWatch::Parts::Run() {
  Backoff backoff(kFirstRetry, kLongestRetry);
  while (true) {
    if (Watch()) backoff.Reset();
    std::unique_lock lock(mutex);
    if (stopped.wait_for(lock, backoff.Next(), [this] { return stopping; })) return;
  }
}

bool MeshWatch::Parts::Watch() {
  grpc::ClientContext own;
  {
    const std::scoped_lock lock(mutex);
    if (stopping) return false;
    context = &own;
  }
  const auto stream = stub->WatchMesh(&own, request);
  MeshReader reader;
  v1::MeshState message;
  while (!reader.is_lost() && stream->Read(&message)) Take(&message, &reader);
  if (reader.is_lost()) own.TryCancel();  // the next stream begins with a topology
  const grpc::Status status = stream->Finish();
  const std::scoped_lock lock(mutex);
  context = nullptr;
  if (!stopping && !reader.is_lost())
    stats.trouble = status.ok() ? "the slave ended the stream" : WordsOf(status);
  return reader.has_topology() && !reader.is_lost();
}

void MeshWatch::Parts::Take(v1::MeshState* message, MeshReader* reader) {
  std::string reason;
  auto mesh = reader->Read(message, &reason);
  const double deflection = mesh ? mesh->LargestDeflection() : 0;
  const std::scoped_lock lock(mutex);
  if (!mesh) {
    ++stats.refused;
    stats.trouble = "a mesh was rejected: " + reason;
    return;
  }
  ++stats.meshes;
  stats.deflection_peak = std::max(stats.deflection_peak, deflection);
  stats.trouble.clear();
  newest = std::make_shared<const RemoteMesh>(std::move(*mesh));
}

MeshWatch::MeshWatch(const Options& options) : parts_(std::make_unique<Parts>(options)) {
  parts_->thread = std::jthread([parts = parts_.get()] { parts->Run(); });
}

MeshWatch::~MeshWatch() {
  Stop();
}

std::shared_ptr<const RemoteMesh> MeshWatch::newest() const {
  const std::scoped_lock lock(parts_->mutex);
  return parts_->newest;
}

MeshWatch::Stats MeshWatch::stats() const {
  const std::scoped_lock lock(parts_->mutex);
  return parts_->stats;
}

void MeshWatch::Stop() {
  {
    const std::scoped_lock lock(parts_->mutex);
    parts_->stopping = true;
    if (parts_->context != nullptr) parts_->context->TryCancel();
  }
  parts_->stopped.notify_all();
  if (parts_->thread.joinable()) parts_->thread.join();
}

}  // namespace palpate
