#include "slave/service/drive_stream.h"

#include <spdlog/spdlog.h>

#include "shared/link/thread_priority.h"
#include "shared/text/text.h"
#include "slave/service/messages.h"

namespace palpate {
namespace {

constexpr double kUsualRate = 500, kSlowest = 100, kFastest = 1000;  // of targets [Hz]
constexpr int kMaxReports = 4000;                                    // per second
constexpr std::size_t kMaxDriverName = 64;                           // [characters]

grpc::Status Refused(const std::string& why) {
  return Error(v1::ERROR_REASON_INVALID_FIELD, why);
}

}  // namespace

DriveStream::DriveStream(StreamedManipulator* arm)
    : arm_(arm), driver_(NewStreamId()), pace_(kMaxReports) {}

DriveStream::Reactor* DriveStream::Open(StreamedManipulator* arm, DriveStreams* streams) {
  if (arm == nullptr) {
    return new RefusedStream<Reactor>(
        Error(v1::ERROR_REASON_NOT_STREAMED,
              "the scene accepts no driver: its manipulator.source is not stream"));
  }
  const std::shared_ptr<DriveStream> stream(new DriveStream(arm));
  stream->self_ = stream;
  if (!streams->Add(stream)) {
    stream->End(Stopping());
  } else {
    stream->Read(&stream->report_);
  }
  return stream.get();
}

grpc::Status DriveStream::Take() {
  const Time now = Clock::now();
  if (!pace_.Allows(now)) {
    return Error(v1::ERROR_REASON_TOO_MANY,
                 "more than " + std::to_string(kMaxReports) +
                     " reports within a second: expected one per target");
  }
  std::string reason;
  const auto reading = FromProto(report_, &reason);
  if (!reading) return Refused(reason);
  if (rate_ == 0) {
    const double rate = report_.rate() == 0 ? kUsualRate : report_.rate();
    if (!(rate >= kSlowest && rate <= kFastest)) {
      return Refused("rate = " + std::to_string(rate) + ": expected 0, or 100 to 1000");
    }
    name_ = Presentable(report_.driver_name(), kMaxDriverName);
    rate_ = rate;
  }
  if (const auto refusal = arm_->Take(driver_, name_, *reading, now)) {
    return Error(refusal->is_held ? v1::ERROR_REASON_SOURCE_TAKEN : v1::ERROR_REASON_INVALID_FIELD,
                 refusal->why);
  }
  return grpc::Status::OK;
}

void DriveStream::OnReadDone(bool ok) {
  if (!Enter()) return;
  const bool is_first = rate_ == 0;
  const grpc::Status taken = ok ? Take() : grpc::Status::OK;
  if (ok && taken.ok() && is_first) StartAiming();
  Exit();
  if (!ok || !taken.ok()) return End(taken);  // the driver left
  Read(&report_);
}

void DriveStream::StartAiming() {
  spdlog::info("the manipulator is driven by {} at {:g} Hz", name_.empty() ? "a driver" : name_,
               rate_);
  aiming_ = std::jthread([this](const std::stop_token& stop) { KeepAiming(stop); });
}

// Only the newest target is sent, so none is prepared while the stream cannot send.
void DriveStream::KeepAiming(const std::stop_token& stop) {
  MakeThreadRealtime(kReadingPriority);
  const auto period = Seconds(1 / rate_);
  Time due = Clock::now();
  while (!stop.stop_requested()) {
    const Time now = Clock::now();
    Write(now);
    due = due + period > now ? due + period : now + period;
    std::this_thread::sleep_until(Clock::ToSteady(due));
  }
}

void DriveStream::Write(Time now) {
  {
    const std::scoped_lock lock(mutex_);
    if (ending_ || writing_) return;
    ToProto(arm_->Aim(now), now, &target_);
    writing_ = true;
    ++busy_;
  }
  StartWrite(&target_);
}

void DriveStream::OnWriteDone(bool ok) {
  {
    const std::scoped_lock lock(mutex_);
    writing_ = false;
  }
  if (!ok) End(grpc::Status::CANCELLED);
  Exit();
}

}  // namespace palpate
