#include "slave/service/nats_feed.h"

#include <utility>

#include <spdlog/spdlog.h>

#include "shared/wire/state_message.h"
#include "slave/service/messages.h"
#include "slave/service/status.h"

namespace palpate {
namespace {

// Period at which a wait checks whether to end.
constexpr std::chrono::milliseconds kFeedPoll(50);
constexpr int kFeedQuality = 80;  // of images, the default of WatchImages

}  // namespace

NatsFeed::NatsFeed(const NatsServer& server, Slave& slave, Publisher& publisher,
                   TeleoperationService& service)
    : slave_(slave),
      publisher_(publisher),
      service_(service),
      name_(slave.Describe().scene.name),
      connection_(server, "palpate-slave " + name_,
                  [](const std::string& news) { spdlog::warn("{}", news); }),
      states_(KindOf("state", kStateRate)),
      meshes_(KindOf("mesh", kBulkRate)),
      images_(KindOf("image", kBulkRate)),
      statuses_(KindOf("status", kStatusRate)) {
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

NatsFeed::Kind NatsFeed::KindOf(std::string_view kind, double rate) const {
  return {.subject = SubjectOf(name_, kind), .gap = Seconds(1 / rate)};
}

void NatsFeed::Run(const std::stop_token& stop) {
  const auto box = publisher_.Subscribe();
  while (!stop.stop_requested() && !box->closed()) {
    if (!connection_.Confirm()) {
      box->PauseUntil(Clock::now() + kFeedPoll);
      continue;
    }
    const auto state = box->WaitNewest(kFeedPoll);
    if (!state) continue;
    const Time now = Clock::now();
    const auto published = Guarded([&] { Publish(*state, now); });
    if (!published.ok() && std::exchange(trouble_, published.error_message()) != trouble_) {
      spdlog::warn("not published: {}", trouble_);
    }
    box->PauseUntil(now + states_.gap);
  }
}

void NatsFeed::Publish(const SlaveState& state, Time now) {
  v1::SlaveState message;
  ToProto(state, &message);
  ToProto(state.details, message.mutable_details());
  Send(message, states_);
  if (now >= statuses_.due) {
    v1::Status status;
    service_.FillStatus(&status);
    Send(status, statuses_);
    statuses_.due = now + statuses_.gap;
  }
  // Each message contains the topology, because a reader may begin with any message and miss any.
  PublishBulk<v1::MeshState>(state, now, &meshes_, [&](v1::MeshState* mesh) {
    BoundaryShape shape = slave_.Shape({});
    shape.state_sequence = state.sequence;
    ToProto(shape, true, mesh);
    return true;
  });
  PublishBulk<v1::ImageState>(state, now, &images_, [&](v1::ImageState* image) {
    const auto encoded = service_.Encoded(state.sensed_at, true, kFeedQuality);
    if (encoded) ToProto(*encoded, state.sequence, image);
    return encoded != nullptr;
  });
}

template <class Message, class Compose>
void NatsFeed::PublishBulk(const SlaveState& state, Time now, Kind* kind, const Compose& compose) {
  if (now < kind->due || state.sensed_at == kind->sensed_at) return;
  if (!service_.bulk_pace().Begin(kind->size, now)) return;
  Message message;
  const double size = compose(&message) ? Send(message, *kind) : 0;
  service_.bulk_pace().End(kind->size, size);
  if (size > 0) kind->size = size;
  kind->sensed_at = state.sensed_at;
  kind->due = now + kind->gap;
}

template <class Message>
double NatsFeed::Send(const Message& message, const Kind& kind) {
  message.SerializeToString(&bytes_);
  return connection_.Publish(kind.subject, bytes_) ? static_cast<double>(bytes_.size()) : 0;
}

}  // namespace palpate
