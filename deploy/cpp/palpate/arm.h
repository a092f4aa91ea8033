// Driver of a manipulator.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include <palpate/v1/teleoperation.grpc.pb.h>

#include "palpate/state.h"

namespace palpate {
// Its symbols are not those of the programs, whose classes have some of the same names.
inline namespace client {

// What the encoders and sensors of a manipulator measure, frame S.
struct ArmReading {
  Vector tip{};                      // tool tip [m]
  std::optional<Vector> velocity{};  // [m/s]
  std::optional<Vector> force{};     // of the object on the tool, by a sensor [N]
  std::string fault{};               // why it does not move; the slave then holds the tool
};

// A manipulator. The calls come one at a time.
class Arm {
 public:
  virtual ~Arm() = default;
  // Reads the encoders; `dt` is the time since the last call [s].
  virtual ArmReading Measure(double dt) = 0;
  // Moves to `tip` [m], which moves with `velocity` [m/s].
  virtual void Go(const Vector& tip, const Vector& velocity) = 0;
  // Holds the present position.
  virtual void Hold() = 0;
  // The driver ends as soon as this is true.
  [[nodiscard]] virtual bool IsDone() const { return false; }
};

// Numbers of messages of a driver.
struct Exchange {
  std::uint64_t reports = 0, targets = 0;
};

// Reports an arm and moves it to the slave's targets. It holds the arm after 100 ms without a
// target, and at the end.
class ArmDriver {
 public:
  ArmDriver(Arm& arm, double rate, double seconds, std::string name)
      : arm_(arm), rate_(rate), seconds_(seconds), name_(std::move(name)) {}

  Exchange Run(v1::Teleoperation::Stub* stub) {
    grpc::ClientContext context;
    const auto stream = stub->DriveTool(&context);
    std::thread reporting([&] {
      const auto begin = Clock::now();
      for (auto last = begin; !has_ended_ && !arm_.IsDone() && Seconds(begin) < seconds_;) {
        const auto now = Clock::now();
        if (!stream->Write(Report(std::chrono::duration<double>(now - last).count()))) return;
        last = now;
        std::this_thread::sleep_until(now + std::chrono::duration<double>(1 / rate_));
      }
      stream->WritesDone();
    });
    v1::ArmTarget target;
    while (stream->Read(&target)) Take(target);
    has_ended_ = true;
    reporting.join();
    arm_.Hold();
    const auto status = stream->Finish();
    if (!status.ok()) throw Error(status);
    return exchange_;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kSilence = 0.1;  // [s]

  static double Seconds(Clock::time_point since) {
    return std::chrono::duration<double>(Clock::now() - since).count();
  }

  void Take(const v1::ArmTarget& target) {
    const std::lock_guard lock(mutex_);
    received_at_ = Clock::now();
    target_ = target.sequence();
    ++exchange_.targets;
    if (target.motion() == v1::ArmTarget::MOTION_FOLLOW) {
      arm_.Go(ToVector(target.p_s_tip()), ToVector(target.velocity()));
    } else {
      arm_.Hold();
    }
  }
  v1::ArmReport Report(double dt) {
    const std::lock_guard lock(mutex_);
    if (Seconds(received_at_) > kSilence) arm_.Hold();
    const ArmReading reading = arm_.Measure(dt);
    v1::ArmReport report;
    report.set_sequence(++exchange_.reports);
    *report.mutable_measured_at() = Now();
    Set(reading.tip, report.mutable_p_s_tip());
    if (reading.velocity) Set(*reading.velocity, report.mutable_velocity());
    if (reading.force) Set(*reading.force, report.mutable_measured_force());
    report.set_fault(reading.fault);
    report.set_driver_name(name_);
    report.set_rate(rate_);
    report.set_target_sequence(target_);
    return report;
  }

  Arm& arm_;
  const double rate_, seconds_;
  const std::string name_;
  std::atomic<bool> has_ended_ = false;
  std::mutex mutex_;  // guards everything below
  Clock::time_point received_at_ = Clock::now();
  std::uint64_t target_ = 0;
  Exchange exchange_;
};

}  // namespace client
}  // namespace palpate
