// WatchMesh: refuse, subscribe, stream, leave.
#include <optional>

#include "slave/service/describe.h"
#include "slave/service/requests.h"
#include "slave/service/status.h"
#include "slave/service/teleoperation_service.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kPatience(50);

}  // namespace

grpc::Status TeleoperationService::WatchMesh(grpc::ServerContext* context,
                                             const v1::WatchMeshRequest* request,
                                             grpc::ServerWriter<v1::MeshState>* writer) {
  Clock::duration gap{};
  if (const auto asked = Guarded([&] { gap = GapOf(*request); }); !asked.ok()) return asked;
  const ObserverSeats::Seat seat(&seats_);
  if (!seat) return ObserverSeats::Full();
  const auto box = publisher_.Subscribe();  // its states tell when there is something new to draw
  std::vector<std::uint32_t> elements;      // as the reader knows them
  std::optional<Time> sensed_at;
  v1::MeshState message;
  while (!box->closed()) {
    if (context->IsCancelled()) return grpc::Status::CANCELLED;
    const auto state = box->WaitNewest(kPatience);
    if (!state || state->sensed_at == sensed_at) continue;
    sensed_at = state->sensed_at;
    const Time due = Clock::now() + gap;
    const auto shaped = Guarded([&] {
      BoundaryShape shape = slave_.Shape(request->nodal_forces());
      shape.state_sequence = state->sequence;
      const bool with_topology = shape.elements != elements;
      ToProto(shape, with_topology, &message);
      elements = std::move(shape.elements);
    });
    if (!shaped.ok()) return shaped;
    if (!writer->Write(message)) return grpc::Status::CANCELLED;
    box->PauseUntil(due);
  }
  return Stopping();
}

}  // namespace palpate
