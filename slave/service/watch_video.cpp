// WatchVideo: refuse, subscribe, stream, leave.
#include <optional>
#include <stdexcept>
#include <utility>

#include "slave/service/describe.h"
#include "slave/service/requests.h"
#include "slave/service/status.h"
#include "slave/service/teleoperation_service.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kPatience(50);

void RequireCamera(const Slave& slave) {
  if (!HasPictures(slave.Describe().scene.sense)) {
    throw std::logic_error("the scene has no camera");
  }
}

}  // namespace

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
  const ObserverSeats::Seat seat(&seats_);
  if (!seat) return ObserverSeats::Full();
  const auto box = publisher_.Subscribe();  // its states tell when there is a new picture
  std::optional<Time> sensed_at;
  v1::VideoFrame message;
  while (!box->closed()) {
    if (context->IsCancelled()) return grpc::Status::CANCELLED;
    const auto state = box->WaitNewest(kPatience);
    if (!state || state->sensed_at == sensed_at) continue;
    const Time due = Clock::now() + gap;
    std::optional<JpegPicture> picture;
    const auto taken = Guarded([&] { picture = slave_.Picture(request->overlays(), quality); });
    if (!taken.ok()) return taken;
    if (!picture) continue;  // nothing seen yet
    sensed_at = state->sensed_at;
    ToProto(std::move(*picture), state->sequence, &message);
    if (!writer->Write(message)) return grpc::Status::CANCELLED;
    box->PauseUntil(due);
  }
  return Stopping();
}

}  // namespace palpate
