#include "master/link/observer.h"

#include <algorithm>
#include <array>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "master/link/remote_patch.h"
#include "master/link/stream_keeper.h"
#include "shared/link/priority_inheritance_mutex.h"
#include "shared/wire/fields.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kPollEvery(1000);
constexpr double kTraceRate = 120;  // without a recording; a recording gets all traces [Hz]
constexpr double kTraceAge = 1;     // [s]
constexpr std::size_t kTracesKept = 2048;
constexpr std::size_t kMaxJpeg = 16 << 20;  // [bytes]
constexpr std::uint32_t kQuality = 75;      // of the JPEG

v1::WatchImagesRequest VideoRequest(const ObservedViews& views) {
  v1::WatchImagesRequest request;
  request.set_max_rate(views.image_rate);
  request.set_overlays(true);
  request.set_quality(kQuality);
  return request;
}

v1::WatchMeshRequest MeshRequest(const ObservedViews& views) {
  v1::WatchMeshRequest request;
  request.set_max_rate(views.mesh_rate);
  request.set_nodal_forces(views.nodal_forces);
  request.set_traction(views.traction);
  request.set_field(views.field);
  return request;
}

v1::WatchTraceRequest TraceRequest(bool all) {
  v1::WatchTraceRequest request;
  if (!all) request.set_max_rate(kTraceRate);
  return request;
}

// Returns the views that both users need.
ObservedViews Both(const ObservedViews& a, const ObservedViews& b) {
  ObservedViews both;
  both.image_rate = std::max(a.image_rate, b.image_rate);
  both.mesh_rate = std::max(a.mesh_rate, b.mesh_rate);
  both.nodal_forces = a.nodal_forces || b.nodal_forces;
  both.traction = a.traction || b.traction;
  both.field = a.field || b.field;
  return both;
}

}  // namespace

struct Observer::Parts {
  Parts(const SlaveLink::Options& link, Options chosen);

  // Store a received message, or return why it is rejected.
  std::string Take(const v1::ImageState& frame);
  std::string Take(const v1::MeshState& message);
  std::string Take(const v1::PatchUpdate& message);
  std::string Take(const v1::TraceUpdate& message);
  void Forward(const google::protobuf::Message& message) const {
    if (options.on_message) options.on_message(message);
  }

  void OpenImages();
  void OpenMeshes();
  void Poll(const std::stop_token& stop);
  // Requests scene and status of the slave. Contains the reason if they are not available.
  SlaveHealth RequestHealth(const std::stop_token& stop);

  [[nodiscard]] ObservedViews needed() const {
    const std::scoped_lock lock(mutex);
    return views;
  }

  const Options options;
  const std::unique_ptr<v1::Teleoperation::Stub> stub;
  // Each of these members is used only by the thread of its stream.
  std::shared_ptr<const MeshTopology> topology;  // of the open stream; null: not received yet
  PatchReader patch_reader;
  std::optional<std::uint32_t> revision;  // of the scene that was forwarded last

  mutable PriorityInheritanceMutex mutex;  // guards the newest values
  ObservedViews views;                     // needed by all users together
  std::shared_ptr<const RemoteImage> image;
  std::uint64_t images_received = 0;
  std::shared_ptr<const RemoteMesh> mesh;
  double deflection_peak = 0;          // [m]
  PatchStats patches;                  // without the counts of the stream keeper
  std::map<Time, SampleTrace> traces;  // by the time of their samples
  SlaveHealth health;
  PriorityInheritanceCondition wake;  // never notified; only for a wait that ends with a stop

  mutable PriorityInheritanceMutex streams_mutex;  // guards the users' needs and their streams
  std::array<ObservedViews, kUsers> needs;
  // Streams, and the thread of the health; null: not needed. They are declared last because they
  // use the members above.
  std::unique_ptr<StreamKeeper<v1::ImageState>> image_stream;
  std::unique_ptr<StreamKeeper<v1::MeshState>> mesh_stream;
  std::unique_ptr<StreamKeeper<v1::PatchUpdate>> patch_stream;
  std::unique_ptr<StreamKeeper<v1::TraceUpdate>> trace_stream;
  std::jthread polling;
};

Observer::Parts::Parts(const SlaveLink::Options& link, Options chosen)
    : options(std::move(chosen)), stub(BulkStub(link)) {
  if (options.patches != nullptr) {
    patch_stream = std::make_unique<StreamKeeper<v1::PatchUpdate>>(
        [this](grpc::ClientContext* call) {
          patch_reader.BeginStream();
          return stub->WatchPatch(call, {});
        },
        [this](v1::PatchUpdate* message) { return Take(*message); });
  }
  const bool records = static_cast<bool>(options.on_message);
  if (!options.health && !records) return;
  trace_stream = std::make_unique<StreamKeeper<v1::TraceUpdate>>(
      [this, records](grpc::ClientContext* call) {
        return stub->WatchTrace(call, TraceRequest(records));
      },
      [this](v1::TraceUpdate* message) { return Take(*message); });
  polling = std::jthread([this](const std::stop_token& stop) { Poll(stop); });
}

void Observer::Parts::OpenImages() {
  image_stream = std::make_unique<StreamKeeper<v1::ImageState>>(
      [this](grpc::ClientContext* call) { return stub->WatchImages(call, VideoRequest(needed())); },
      [this](v1::ImageState* frame) { return Take(*frame); });
}

void Observer::Parts::OpenMeshes() {
  mesh_stream = std::make_unique<StreamKeeper<v1::MeshState>>(
      [this](grpc::ClientContext* call) {
        topology = nullptr;
        return stub->WatchMesh(call, MeshRequest(needed()));
      },
      [this](v1::MeshState* message) { return Take(*message); });
}

std::string Observer::Parts::Take(const v1::ImageState& frame) {
  std::string reason;
  FieldReader reader(&reason);
  const Time sensed_at = reader.Stamp("sensed_at", frame.sensed_at());
  if (!reader.ok() || frame.jpeg().empty() || frame.jpeg().size() > kMaxJpeg) return {};
  Forward(frame);
  const std::scoped_lock lock(mutex);
  image = std::make_shared<const RemoteImage>(
      RemoteImage{++images_received, sensed_at, static_cast<int>(frame.width()),
                  static_cast<int>(frame.height()), frame.jpeg()});
  return {};
}

std::string Observer::Parts::Take(const v1::MeshState& message) {
  std::string reason;
  auto read = FromProto(message, topology, &reason);
  if (!read) return "a mesh was rejected: " + reason;
  topology = read->topology;
  Forward(message);
  const double deflection = read->LargestDeflection();
  const std::scoped_lock lock(mutex);
  deflection_peak = std::max(deflection_peak, deflection);
  mesh = std::make_shared<const RemoteMesh>(std::move(*read));
  return {};
}

std::string Observer::Parts::Take(const v1::PatchUpdate& message) {
  std::string reason;
  const ReceivedPatch* newest = patch_reader.Read(message, &reason);
  if (newest != nullptr) options.patches->Put(*newest);
  const std::scoped_lock lock(mutex);
  patches.bytes += message.ByteSizeLong();
  if (newest == nullptr) return "a patch was rejected: " + reason;
  ++(message.has_patch() ? patches.patches : patches.laws);
  return {};
}

std::string Observer::Parts::Take(const v1::TraceUpdate& message) {
  Forward(message);
  const std::scoped_lock lock(mutex);
  for (const v1::SampleTrace& sample : message.samples()) {
    std::string reason;
    if (const auto trace = FromProto(sample, &reason)) traces[trace->sensed_at] = *trace;
  }
  const auto is_old = [this] {
    return SecondsBetween(traces.begin()->first, traces.rbegin()->first) > kTraceAge;
  };
  while (!traces.empty() && (is_old() || traces.size() > kTracesKept)) {
    traces.erase(traces.begin());
  }
  return {};
}

void Observer::Parts::Poll(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    SlaveHealth answer = RequestHealth(stop);
    std::unique_lock lock(mutex);
    answer.version = health.version + 1;
    health = std::move(answer);
    wake.wait_until(lock, stop, std::chrono::steady_clock::now() + kPollEvery,
                    [] { return false; });
  }
}

SlaveHealth Observer::Parts::RequestHealth(const std::stop_token& stop) {
  using Stub = v1::Teleoperation::Stub;
  v1::Status status;
  v1::SceneDescription scene;
  grpc::Status answer = Query(stub.get(), &Stub::GetStatus, stop, &status);
  if (answer.ok()) {
    Forward(status);
    answer = Query(stub.get(), &Stub::GetScene, stop, &scene);
  }
  if (!answer.ok()) return {.trouble = WordsOf(answer)};
  if (revision != scene.settings_revision()) {
    revision = scene.settings_revision();
    Forward(scene);
  }
  SlaveHealth taken{.scene = scene, .status = status};
  try {
    taken.remote = ToRemoteScene(scene);
  } catch (const std::runtime_error&) {  // the link reports it
  }
  return taken;
}

Observer::Observer(const SlaveLink::Options& link, Options options)
    : parts_(std::make_unique<Parts>(link, std::move(options))) {}

Observer::~Observer() = default;

void Observer::Need(User user, const ObservedViews& views) {
  Parts& parts = *parts_;
  const std::scoped_lock streams_lock(parts.streams_mutex);
  parts.needs[static_cast<std::size_t>(user)] = views;
  ObservedViews all;
  for (const ObservedViews& need : parts.needs) all = Both(all, need);
  const ObservedViews before = parts.needed();
  if (all == before) return;
  if (all.image_rate == 0) parts.image_stream.reset();
  if (all.mesh_rate == 0 && parts.mesh_stream) parts.mesh_stream->Stop();
  {
    const std::scoped_lock lock(parts.mutex);
    parts.views = all;
    if (all.image_rate == 0) parts.image.reset();
  }
  if (all.image_rate > 0 && !parts.image_stream) {
    parts.OpenImages();
  } else if (all.image_rate != before.image_rate && parts.image_stream) {
    parts.image_stream->Reopen();
  }
  if (all.mesh_rate > 0 && before.mesh_rate == 0) {
    parts.OpenMeshes();
  } else if (all.mesh_rate > 0) {
    parts.mesh_stream->Reopen();
  }
}

std::shared_ptr<const RemoteImage> Observer::image() const {
  const std::scoped_lock lock(parts_->mutex);
  return parts_->image;
}

std::string Observer::image_trouble() const {
  const std::scoped_lock lock(parts_->streams_mutex);
  return parts_->image_stream ? parts_->image_stream->stats().trouble : std::string();
}

std::shared_ptr<const RemoteMesh> Observer::mesh() const {
  const std::scoped_lock lock(parts_->mutex);
  return parts_->mesh;
}

Observer::MeshStats Observer::mesh_stats() const {
  const std::scoped_lock streams_lock(parts_->streams_mutex);
  if (!parts_->mesh_stream) return {};
  const auto kept = parts_->mesh_stream->stats();
  const std::scoped_lock lock(parts_->mutex);
  return {kept.accepted, kept.rejected, parts_->deflection_peak, kept.trouble};
}

PatchStats Observer::patch_stats() const {
  if (!parts_->patch_stream) return {};
  const auto kept = parts_->patch_stream->stats();
  const std::scoped_lock lock(parts_->mutex);
  PatchStats stats = parts_->patches;
  stats.refused = kept.rejected;
  stats.trouble = kept.trouble;
  return stats;
}

std::optional<SampleTrace> Observer::TraceOf(Time sensed_at) const {
  const std::scoped_lock lock(parts_->mutex);
  const auto found = parts_->traces.find(sensed_at);
  return found == parts_->traces.end() ? std::nullopt : std::optional(found->second);
}

SlaveHealth Observer::health() const {
  const std::scoped_lock lock(parts_->mutex);
  return parts_->health;
}

}  // namespace palpate
