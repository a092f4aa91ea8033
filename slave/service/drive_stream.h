// The stream of a manipulator's driver: reports in, targets out at the requested rate.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include <grpcpp/support/server_callback.h>

#include "palpate/v1/devices.pb.h"

#include "slave/capture/pace_limit.h"
#include "slave/manipulator/streamed_manipulator.h"
#include "slave/service/status.h"
#include "slave/service/stream_list.h"

namespace palpate {

class DriveStream;
using DriveStreams = StreamList<DriveStream>;

class DriveStream final
    : public EndingStream<grpc::ServerBidiReactor<v1::ArmReport, v1::ArmTarget>> {
 public:
  using Reactor = grpc::ServerBidiReactor<v1::ArmReport, v1::ArmTarget>;

  // `arm` outlives the stream; null: the stream is rejected.
  static Reactor* Open(StreamedManipulator* arm, DriveStreams* streams);

  // The slave is stopping.
  void Close() { End(Stopping()); }

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;

 private:
  explicit DriveStream(StreamedManipulator* arm);

  // Why the report that was read cannot be taken; OK: it was.
  grpc::Status Take();
  void StartAiming();
  void KeepAiming(const std::stop_token& stop);
  void Write(Time now);
  void OnQuiet() override { arm_->Leave(driver_); }

  StreamedManipulator* const arm_;
  const DriverId driver_;
  v1::ArmReport report_;  // gRPC's while a read is waiting
  v1::ArmTarget target_;  // gRPC's while `writing_`
  std::string name_;      // used by the reading thread only, as the next two
  double rate_ = 0;       // rate of targets [Hz]; 0: not yet set
  PaceLimit pace_;
  bool writing_ = false;  // guarded by mutex_
  std::jthread aiming_;   // last: it uses all of the above
};

}  // namespace palpate
