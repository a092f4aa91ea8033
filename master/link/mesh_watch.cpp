#include "master/link/mesh_watch.h"

#include <algorithm>

#include "master/link/stream_keeper.h"

namespace palpate {
namespace {

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
  Parts(const SlaveLink::Options& link, const Options& options)
      : request(Request(options)), stub(BulkStub(link)) {}

  // Why the mesh is rejected; empty: it is not.
  std::string Take(v1::MeshState* message) {
    std::string reason;
    auto mesh = reader.Read(message, &reason);
    if (!mesh) {
      if (reader.is_lost()) keeper.Reopen();  // the next stream begins with a topology
      return "a mesh was rejected: " + reason;
    }
    const double deflection = mesh->LargestDeflection();
    const std::scoped_lock lock(mutex);
    deflection_peak = std::max(deflection_peak, deflection);
    newest = std::make_shared<const RemoteMesh>(std::move(*mesh));
    return {};
  }

  const v1::WatchMeshRequest request;
  const std::unique_ptr<v1::Teleoperation::Stub> stub;
  MeshReader reader;           // of the open stream; used by the keeper's thread only
  mutable std::mutex mutex;    // guards what follows
  double deflection_peak = 0;  // [m]
  std::shared_ptr<const RemoteMesh> newest;
  StreamKeeper<v1::MeshState> keeper{
      [this](grpc::ClientContext* context) {
        reader = MeshReader();
        return stub->WatchMesh(context, request);
      },
      [this](v1::MeshState* message) { return Take(message); }};  // last: it uses all of the above
};

MeshWatch::MeshWatch(const SlaveLink::Options& link, const Options& options)
    : parts_(std::make_unique<Parts>(link, options)) {}

MeshWatch::~MeshWatch() = default;

std::shared_ptr<const RemoteMesh> MeshWatch::newest() const {
  const std::scoped_lock lock(parts_->mutex);
  return parts_->newest;
}

MeshWatch::Stats MeshWatch::stats() const {
  const auto stats = parts_->keeper.stats();
  const std::scoped_lock lock(parts_->mutex);
  return {stats.accepted, stats.rejected, parts_->deflection_peak, stats.trouble};
}

void MeshWatch::Stop() {
  parts_->keeper.Stop();
}

}  // namespace palpate
