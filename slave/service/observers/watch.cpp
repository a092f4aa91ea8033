// WatchState, WatchMesh, WatchTrace, WatchPatch, WatchVideo.
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "shared/link/thread_priority.h"
#include "shared/wire/fields.h"
#include "shared/wire/patch_message.h"
#include "shared/wire/state_message.h"
#include "shared/wire/trace_message.h"
#include "slave/service/messages.h"
#include "slave/service/observers/mesh_stream_encoder.h"
#include "slave/service/status.h"
#include "slave/service/teleoperation_service.h"

namespace palpate {
namespace {

// How long a silent stream may go without a look whether the reader is still there.
constexpr std::chrono::milliseconds kPatience(50);

void RequireCamera(const Slave& slave) {
  if (!HasPictures(slave.Describe().scene.sense)) {
    throw std::logic_error("the scene has no camera");
  }
}

}  // namespace

template <class Message, class Compose>
grpc::Status TeleoperationService::Watch(grpc::ServerContext* context, Clock::duration gap,
                                         grpc::ServerWriter<Message>* writer,
                                         const Compose& compose) {
  const OrdinaryPriority ordinary;
  if (lines_.on_stream) lines_.on_stream(*context);
  const ObserverSeats::Seat seat(&seats_);
  if (!seat) return ObserverSeats::Full();
  const auto box = publisher_.Subscribe();  // its states tell when there is something new
  Message message;
  while (!box->closed()) {
    if (context->IsCancelled()) return grpc::Status::CANCELLED;
    const auto state = box->WaitNewest(kPatience);
    if (!state) continue;
    const Time due = Clock::now() + gap;
    bool is_new = false;
    const auto composed = Guarded([&] { is_new = compose(*state, &message); });
    if (!composed.ok()) return composed;
    if (!is_new) continue;
    if (!writer->Write(message)) return grpc::Status::CANCELLED;  // the reader left
    if constexpr (std::is_same_v<Message, v1::SlaveState>) ++states_sent_;
    box->PauseUntil(due);
  }
  return Stopping();
}

grpc::Status TeleoperationService::WatchState(grpc::ServerContext* context,
                                              const v1::WatchStateRequest* request,
                                              grpc::ServerWriter<v1::SlaveState>* writer) {
  Clock::duration gap{};
  if (const auto asked = Guarded([&] { gap = GapOf(*request); }); !asked.ok()) return asked;
  return Watch(context, gap, writer, [&](const SlaveState& state, v1::SlaveState* message) {
    ToProto(state, message);
    if (!request->details()) return true;
    ToProto(state.details, message->mutable_details());
    if (state.moment) ToProto(*state.moment, message->mutable_moment());
    return true;
  });
}

grpc::Status TeleoperationService::WatchMesh(grpc::ServerContext* context,
                                             const v1::WatchMeshRequest* request,
                                             grpc::ServerWriter<v1::MeshState>* writer) {
  Clock::duration gap{};
  std::optional<MeshStreamEncoder> encoder;
  const auto asked = Guarded([&] {
    gap = GapOf(*request);
    encoder.emplace(*request);
  });
  if (!asked.ok()) return asked;
  if (lines_.on_bulk) lines_.on_bulk(context->peer());
  std::optional<Time> sensed_at;
  return Watch(context, gap, writer, [&](const SlaveState& state, v1::MeshState* message) {
    if (std::exchange(sensed_at, state.sensed_at) == state.sensed_at) return false;
    BoundaryShape shape = slave_.Shape(encoder->needs_nodal_forces());
    shape.state_sequence = state.sequence;
    encoder->Encode(shape, message);
    return true;
  });
}

grpc::Status TeleoperationService::WatchTrace(grpc::ServerContext* context,
                                              const v1::WatchTraceRequest* request,
                                              grpc::ServerWriter<v1::TraceUpdate>* writer) {
  Clock::duration gap{};
  if (const auto asked = Guarded([&] { gap = GapOf(*request); }); !asked.ok()) return asked;
  Time told{};
  return Watch(context, gap, writer, [&](const SlaveState& /*state*/, v1::TraceUpdate* message) {
    const std::vector<SampleTrace> traces = slave_.TracesSince(told);
    message->Clear();
    for (const SampleTrace& trace : traces) ToProto(trace, message->add_samples());
    if (!traces.empty()) told = traces.back().sensed_at;
    return !traces.empty();
  });
}

grpc::Status TeleoperationService::WatchPatch(grpc::ServerContext* context,
                                              const v1::WatchPatchRequest* /*request*/,
                                              grpc::ServerWriter<v1::PatchUpdate>* writer) {
  std::uint32_t epoch = 0, revision = 0;  // as the reader knows them
  return Watch(context, {}, writer, [&](const SlaveState& /*state*/, v1::PatchUpdate* message) {
    const PatchSnapshot news = slave_.Patch();
    const bool is_known = news.law.epoch == epoch && news.law.revision == revision;
    if (!news.patch || is_known) return false;
    message->Clear();
    if (news.patch->epoch != epoch) ToProto(*news.patch, message->mutable_patch());
    ToProto(news.law, message->mutable_law());
    epoch = news.law.epoch;
    revision = news.law.revision;
    return true;
  });
}

std::shared_ptr<const JpegPicture> TeleoperationService::Encoded(Time sensed_at, bool overlays,
                                                                 int quality) {
  const std::scoped_lock one_at_a_time(encoding_);
  auto& known = encoded_[{overlays, quality}];
  if (known && known->sensed_at >= sensed_at) return known;
  std::optional<JpegPicture> picture = slave_.Picture(overlays, quality);
  if (picture) known = std::make_shared<const JpegPicture>(std::move(*picture));
  return picture ? known : nullptr;
}

grpc::Status TeleoperationService::WatchVideo(grpc::ServerContext* context,
                                              const v1::WatchVideoRequest* request,
                                              grpc::ServerWriter<v1::VideoFrame>* writer) {
  Clock::duration gap{};
  int quality = 0;
  const auto asked = Guarded([&] {
    gap = GapOf(*request);
    quality = QualityOf(*request);
    RequireCamera(slave_);
  });
  if (!asked.ok()) return asked;
  if (lines_.on_bulk) lines_.on_bulk(context->peer());
  std::optional<Time> sensed_at;
  return Watch(context, gap, writer, [&](const SlaveState& state, v1::VideoFrame* message) {
    if (state.sensed_at == sensed_at) return false;
    const auto picture = Encoded(state.sensed_at, request->overlays(), quality);
    if (!picture) return false;  // nothing seen yet
    sensed_at = state.sensed_at;
    ToProto(*picture, state.sequence, message);
    return true;
  });
}

}  // namespace palpate
