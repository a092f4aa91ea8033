// WatchState, WatchMesh, WatchTrace, WatchPatch, WatchImages.
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "shared/link/thread_priority.h"
#include "shared/wire/fields.h"
#include "shared/wire/patch_message.h"
#include "shared/wire/state_message.h"
#include "slave/service/messages.h"
#include "slave/service/observers/mesh_stream_encoder.h"
#include "slave/service/roles.h"
#include "slave/service/status.h"
#include "slave/service/teleoperation_service.h"

namespace palpate {
namespace {

// Period at which a silent stream checks whether its reader is still there.
constexpr std::chrono::milliseconds kWatchPoll(50);
constexpr std::chrono::milliseconds kPaceWait(5);  // pause until a stream tries again to send

void RequireCamera(const Slave& slave) {
  if (!HasImages(slave.Describe().scene.sense)) {
    throw RejectedCall(v1::ERROR_REASON_NO_CAMERA, "the scene has no camera");
  }
}

}  // namespace

template <class Message, class Prepare, class Compose>
grpc::Status TeleoperationService::Watch(grpc::ServerContext* context, const Prepare& prepare,
                                         BulkPace* pace, grpc::ServerWriter<Message>* writer,
                                         const Compose& compose) {
  Clock::duration gap{};
  if (const auto asked = Guarded([&] { gap = prepare(); }); !asked.ok()) return asked;
  on_stream_(*context, 0);
  const bool is_operators = lease_.IsHeldBy(context->peer(), OperatorNameOf(*context));
  const Seats::Seat seat(&seats_, is_operators);
  if (!seat) {
    const std::string why = std::to_string(kSeats) + " streams are open already";
    refused_.Add("a stream of " + Message::descriptor()->name(), ClientOf(*context), why);
    return Error(v1::ERROR_REASON_TOO_MANY, why);
  }
  const auto box = publisher_.Subscribe();  // its states indicate new data
  Message message;
  double bytes = 0;  // of the previous message
  while (!box->closed()) {
    if (context->IsCancelled()) return grpc::Status::CANCELLED;
    const auto state = box->WaitNewest(kWatchPoll);
    if (!state) continue;
    const Time now = Clock::now(), due = now + gap;
    if (pace != nullptr && !pace->Begin(bytes, now)) {
      box->PauseUntil(now + kPaceWait);
      continue;
    }
    bool is_new = false;
    // Calls of gRPC have the priority of its readers: this thread may read for all connections.
    const auto composed = Guarded([&] {
      const OrdinaryPriority ordinary;
      is_new = compose(*state, &message);
    });
    const double size = is_new ? static_cast<double>(message.ByteSizeLong()) : 0;
    if (pace != nullptr) pace->End(bytes, size);
    if (is_new) bytes = size;
    if (!composed.ok()) return composed;
    if (!is_new) continue;
    if (!writer->Write(message)) return grpc::Status::CANCELLED;  // the reader left
    if constexpr (std::is_same_v<Message, v1::SlaveState>) ++states_sent_;
    box->PauseUntil(due);
  }
  return Stopping(lease_.is_closed());
}

grpc::Status TeleoperationService::WatchState(grpc::ServerContext* context,
                                              const v1::WatchStateRequest* request,
                                              grpc::ServerWriter<v1::SlaveState>* writer) {
  const auto prepare = [&] { return GapOf(*request); };
  return Watch(context, prepare, nullptr, writer,
               [&](const SlaveState& state, v1::SlaveState* message) {
                 ToProto(state, message);
                 if (request->details()) {
                   ToProto(state.details, message->mutable_details());
                 } else {
                   message->clear_moment();
                   message->clear_moment_sigma();
                 }
                 return true;
               });
}

grpc::Status TeleoperationService::WatchMesh(grpc::ServerContext* context,
                                             const v1::WatchMeshRequest* request,
                                             grpc::ServerWriter<v1::MeshState>* writer) {
  std::optional<MeshStreamEncoder> encoder;
  context->set_compression_level(GRPC_COMPRESS_LEVEL_LOW);  // large and similar numbers
  const auto prepare = [&] {
    encoder.emplace(*request);
    return GapOf(*request);
  };
  std::optional<Time> sensed_at;
  std::uint32_t revision = 0;  // another revision may have another object
  return Watch(context, prepare, &bulk_pace_, writer,
               [&](const SlaveState& state, v1::MeshState* message) {
                 if (std::exchange(sensed_at, state.sensed_at) == state.sensed_at) return false;
                 if (std::exchange(revision, state.settings_revision) != state.settings_revision)
                   encoder.emplace(*request);
                 BoundaryShape shape = slave_.Shape(encoder->needs());
                 shape.state_sequence = state.sequence;
                 encoder->Encode(shape, message);
                 return true;
               });
}

grpc::Status TeleoperationService::WatchTrace(grpc::ServerContext* context,
                                              const v1::WatchTraceRequest* request,
                                              grpc::ServerWriter<v1::TraceUpdate>* writer) {
  const auto prepare = [&] { return GapOf(*request); };
  Time sent{};
  return Watch(context, prepare, nullptr, writer,
               [&](const SlaveState& /*state*/, v1::TraceUpdate* message) {
                 const std::vector<SampleTrace> traces = slave_.TracesSince(sent);
                 message->Clear();
                 for (const SampleTrace& trace : traces) ToProto(trace, message->add_samples());
                 if (!traces.empty()) sent = traces.back().sensed_at;
                 return !traces.empty();
               });
}

grpc::Status TeleoperationService::WatchPatch(grpc::ServerContext* context,
                                              const v1::WatchPatchRequest* /*request*/,
                                              grpc::ServerWriter<v1::PatchUpdate>* writer) {
  std::uint32_t epoch = 0, revision = 0, settings = 0;  // as last sent to the reader
  return Watch(
      context, [] { return Clock::duration{}; }, nullptr, writer,
      [&](const SlaveState& state, v1::PatchUpdate* message) {
        if (std::exchange(settings, state.settings_revision) != state.settings_revision) epoch = 0;
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

std::shared_ptr<const EncodedImage> TeleoperationService::Encoded(Time sensed_at, bool overlays,
                                                                  int quality) {
  const std::scoped_lock one_at_a_time(encoding_);
  for (const CachedImage& known : encoded_) {
    const bool is_asked = known.overlays == overlays && known.quality == quality;
    if (is_asked && known.image->sensed_at >= sensed_at) return known.image;
  }
  std::optional<EncodedImage> image = slave_.Image(overlays, quality);
  if (!image) return nullptr;
  std::erase_if(encoded_, [&](const CachedImage& known) {
    return known.image->sensed_at < image->sensed_at;
  });
  if (encoded_.size() >= kMaxEncoded) encoded_.pop_back();
  encoded_.push_front({overlays, quality, std::make_shared<const EncodedImage>(std::move(*image))});
  return encoded_.front().image;
}

grpc::Status TeleoperationService::WatchImages(grpc::ServerContext* context,
                                               const v1::WatchImagesRequest* request,
                                               grpc::ServerWriter<v1::ImageState>* writer) {
  int quality = 0;
  const auto prepare = [&] {
    quality = QualityOf(*request);
    RequireCamera(slave_);
    return GapOf(*request);
  };
  std::optional<Time> sensed_at;
  return Watch(context, prepare, &bulk_pace_, writer,
               [&](const SlaveState& state, v1::ImageState* message) {
                 if (state.sensed_at == sensed_at) return false;
                 const auto image = Encoded(state.sensed_at, request->overlays(), quality);
                 if (!image) return false;  // no image yet
                 sensed_at = state.sensed_at;
                 ToProto(*image, state.sequence, message);
                 return true;
               });
}

}  // namespace palpate
