// WatchState: refuse, subscribe, stream, leave.
#include "shared/wire/state_message.h"
#include "slave/service/requests.h"
#include "slave/service/status.h"
#include "slave/service/teleoperation_service.h"

namespace palpate {
namespace {

// How long a silent stream may go without a look whether the reader is still there.
constexpr std::chrono::milliseconds kPatience(50);

}  // namespace

grpc::Status TeleoperationService::WatchState(grpc::ServerContext* context,
                                              const v1::WatchStateRequest* request,
                                              grpc::ServerWriter<v1::SlaveState>* writer) {
  Clock::duration gap{};
  if (const auto asked = Guarded([&] { gap = GapOf(*request); }); !asked.ok()) return asked;
  const ObserverSeats::Seat seat(&seats_);
  if (!seat) return ObserverSeats::Full();
  const auto box = publisher_.Subscribe();
  v1::SlaveState message;
  while (!box->closed()) {
    if (context->IsCancelled()) return grpc::Status::CANCELLED;
    const auto state = box->WaitNewest(kPatience);
    if (!state) continue;
    const Time due = Clock::now() + gap;
    ToProto(*state, &message);
    if (!writer->Write(message)) return grpc::Status::CANCELLED;  // the reader left
    ++states_sent_;
    box->PauseUntil(due);
  }
  return Stopping();
}

}  // namespace palpate
