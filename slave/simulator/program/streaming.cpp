#include "slave/simulator/program/streaming.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <exception>
#include <limits>
#include <optional>
#include <thread>

#include <palpate/client.h>
#include <spdlog/spdlog.h>

#include "slave/simulator/program/driver_messages.h"
#include "slave/simulator/program/simulated_arm.h"

namespace palpate {
namespace {

constexpr double kReportRate = 500;  // of the manipulator [Hz]

// From the instant of a sample to its sending: what the simulation costs.
class Delay {
 public:
  void Add(Time sensed_at) {
    const double delay = SecondsBetween(sensed_at, Clock::now());
    sum_ += delay;
    largest_ = std::max(largest_, delay);
    ++count_;
  }
  ~Delay() {
    if (count_ == 0) return;
    spdlog::info("{} samples, computed in {:.1f} ms on average, {:.1f} ms at most", count_,
                 1e3 * sum_ / static_cast<double>(count_), 1e3 * largest_);
  }

 private:
  double sum_ = 0, largest_ = 0;  // [s]
  std::uint64_t count_ = 0;
};

template <typename Source>
void FeedFrom(Source& source, const Slave& slave, const std::stop_token& stop) {
  Delay delay;
  (void)slave.FeedImages([&]() -> std::optional<v1::PictureSample> {
    const auto sample = source.Next(stop);
    if (!sample) return std::nullopt;
    v1::PictureSample message = ToMessage(*sample);
    delay.Add(sample->sensed_at);
    return message;
  });
}

void FeedFrom(TactileSource& source, const std::vector<Finger>& fingers, const Slave& slave,
              const std::stop_token& stop) {
  Delay delay;
  std::deque<v1::TactileSample> waiting;  // of the same instant
  (void)slave.FeedFingertips([&]() -> std::optional<v1::TactileSample> {
    if (waiting.empty()) {
      const auto frame = source.Next(stop);
      if (!frame) return std::nullopt;
      std::ranges::move(ToMessages(*frame, fingers), std::back_inserter(waiting));
      delay.Add(frame->sensed_at);
    }
    v1::TactileSample message = std::move(waiting.front());
    waiting.pop_front();
    return message;
  });
}

void Feed(const Scene& scene, SimulatedEnvironment& environment, const Slave& slave,
          const std::stop_token& stop) {
  if (const auto* tactile = scene.sense.Find<Tactile>()) {
    FeedFrom(*environment.OpenFingertips(scene, {}), tactile->fingers, slave, stop);
  } else if (HasStereoOrDepth(scene.sense)) {
    FeedFrom(*environment.OpenPair(scene, {}), slave, stop);
  } else {
    FeedFrom(*environment.OpenCamera(scene, {}), slave, stop);
  }
}

}  // namespace

void StreamTo(const StreamingTarget& target, const Scene& scene, SimulatedEnvironment& environment,
              const std::stop_token& stop) {
  environment.SolveAhead();
  environment.MoveTool(scene.manipulator.home, Patience::kNone);
  const Slave slave(target.address, target.tls);
  std::printf("streaming to %s\n", target.address.c_str());
  std::fflush(stdout);
  std::stop_source end;  // by `stop`, or because one of the streams ended
  const std::stop_callback ends(stop, [&] { end.request_stop(); });
  std::exception_ptr failure;
  std::jthread driving([&] {
    try {
      SimulatedArm arm(environment, scene.manipulator.home, end.get_token());
      (void)slave.Drive(arm, kReportRate, std::numeric_limits<double>::infinity(), "simulator");
    } catch (...) {
      failure = std::current_exception();
    }
    end.request_stop();
  });
  try {
    Feed(scene, environment, slave, end.get_token());
  } catch (...) {
    end.request_stop();
    driving.join();
    throw;
  }
  end.request_stop();
  driving.join();
  if (failure && !stop.stop_requested()) std::rethrow_exception(failure);
}

}  // namespace palpate
