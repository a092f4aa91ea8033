#include "slave/simulator/program/streaming.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <exception>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include <palpate/client.h>
#include <spdlog/spdlog.h>

#include "slave/simulator/camera/scripted_press.h"
#include "slave/simulator/program/driver_messages.h"
#include "slave/simulator/program/simulated_arm.h"
#include "slave/simulator/program/tool_socket.h"

namespace palpate {
namespace {

constexpr double kReportRate = 500;             // of the manipulator [Hz]
constexpr std::chrono::milliseconds kPoll{50};  // polling period of the slave's status

// Measures the delay from the time of a sample to its sending, which is the cost of the simulation.
class Delay {
 public:
  double Add(Time sensed_at) {
    const double delay = SecondsBetween(sensed_at, Clock::now());
    sum_ += delay;
    largest_ = std::max(largest_, delay);
    ++count_;
    return std::clamp(delay, 0.0, 1.0);
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
  (void)slave.FeedImages([&]() -> std::optional<v1::ImageSample> {
    const auto sample = source.Next(stop);
    if (!sample) return std::nullopt;
    v1::ImageSample message = ToMessage(*sample);
    message.set_delay(delay.Add(sample->sensed_at));
    return message;
  });
}

void FeedFrom(TactileSource& source, const std::vector<Finger>& fingers, const Slave& slave,
              const std::stop_token& stop) {
  Delay delay;
  std::deque<v1::TactileSample> waiting;  // samples of the same time
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

void Print(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
}

// Threads that end together: by `stop`, or because one of them ended.
class Streams {
 public:
  explicit Streams(const std::stop_token& stop)
      : stop_(stop), on_stop_(stop, [this] { end_.request_stop(); }) {}
  ~Streams() { end_.request_stop(); }
  Streams(const Streams&) = delete;
  Streams& operator=(const Streams&) = delete;

  [[nodiscard]] std::stop_token end() const { return end_.get_token(); }
  template <typename Stream>
  void Run(Stream stream) {
    threads_.emplace_back([this, stream] {
      try {
        stream();
      } catch (...) {
        const std::lock_guard lock(mutex_);
        if (!end_.stop_requested() && !failure_) failure_ = std::current_exception();
      }
      end_.request_stop();
    });
  }
  // Rethrows the first exception that ended one of them.
  void Join() {
    for (std::jthread& thread : threads_) thread.join();
    if (failure_ && !stop_.stop_requested()) std::rethrow_exception(failure_);
  }

 private:
  const std::stop_token stop_;
  std::stop_source end_;
  std::mutex mutex_;            // guards the next member: two streams may fail at once
  std::exception_ptr failure_;  // written before `end_` is requested
  std::stop_callback<std::function<void()>> on_stop_;
  std::vector<std::jthread> threads_;  // last: they use everything above
};

// Returns what is missing until the slave estimates from samples after the first `frames`, and
// drives its tool; empty: nothing. If it estimates a force, its baseline must be known as well.
std::string Missing(const v1::Status& status, std::uint64_t frames, bool has_force) {
  if (!status.cameras().trouble().empty()) return "cameras: " + status.cameras().trouble();
  if (!status.arm().fault().empty()) return "manipulator: " + status.arm().fault();
  if (status.samples() <= frames) return "it has used no sample";
  if (has_force && status.validity() != v1::VALIDITY_VALID) {
    return "its estimate is " + v1::Validity_Name(status.validity()) + ", expected " +
           v1::Validity_Name(v1::VALIDITY_VALID);
  }
  return "";
}

// Does the same with a status request, and waits for a slow answer.
std::string Missing(const Slave& slave, std::uint64_t frames, bool has_force) {
  try {
    return Missing(slave.Status(), frames, has_force);
  } catch (const Error& error) {
    if (error.code() != grpc::DEADLINE_EXCEEDED) throw;
    return "it does not answer";
  }
}

// Returns when nothing is missing, or at `end`. A wait for more than kReportAfter is reported once.
void AwaitEstimates(const Slave& slave, std::uint64_t frames, bool has_force,
                    const std::stop_token& end) {
  constexpr double kReportAfter = 5;  // [s]
  const Time begin = Clock::now();
  bool is_reported = false;
  while (!end.stop_requested()) {
    const std::string missing = Missing(slave, frames, has_force);
    if (missing.empty()) return;
    if (SecondsBetween(begin, Clock::now()) > kReportAfter && !std::exchange(is_reported, true)) {
      spdlog::warn("waiting for the slave: {}", missing);
    }
    std::this_thread::sleep_for(kPoll);
  }
}

// Simulates a person who presses repeatedly.
void PressByItself(const Scene& scene, SimulatedEnvironment& environment,
                   const std::stop_token& stop) {
  if (!scene.sense.Find<Camera>()) {
    throw std::invalid_argument(
        "manipulator: none: only a tool before one camera presses by itself; expected a "
        "manipulator");
  }
  PressMotion motion = ScriptedPress(scene);
  motion.presses = std::numeric_limits<int>::max();
  const Time begin = Clock::now();
  while (!stop.stop_requested()) {
    const double t = SecondsBetween(begin, Clock::now());
    environment.MoveTool(motion.Tip(t) + environment.HandOffset(t), WhenUnsolved::kUseNearest);
    std::this_thread::sleep_for(Seconds(1 / kReportRate));
  }
}

}  // namespace

void StreamTo(const StreamingTarget& target, const Scene& scene, SimulatedEnvironment& environment,
              const std::stop_token& stop) {
  environment.SolveAhead();
  environment.MoveTool(scene.manipulator.home, WhenUnsolved::kUseNearest);
  const Slave sensor(target.address, target.tls.empty() ? target.tls : target.tls / "sensor");
  const Slave arm(target.address, target.tls.empty() ? target.tls : target.tls / "arm");
  const std::uint64_t frames = sensor.Status().samples();
  const bool has_force = !environment.target();
  Streams streams(stop);
  const std::stop_token end = streams.end();
  std::optional<ToolSocket> tool;
  if (scene.manipulator.source == ManipulatorOptions::Source::kStream) {
    tool.emplace(environment);
    Print("tool on " + tool->address());
  } else if (scene.manipulator.source == ManipulatorOptions::Source::kNone) {
    streams.Run([&] { PressByItself(scene, environment, end); });
  } else {
    streams.Run([&] {
      SimulatedArm simulated(environment, scene.manipulator.home, end);
      (void)arm.Drive(simulated, kReportRate, std::numeric_limits<double>::infinity(), "simulator");
    });
  }
  streams.Run([&] { Feed(scene, environment, sensor, end); });
  AwaitEstimates(sensor, frames, has_force, end);
  if (!end.stop_requested()) Print("streaming to " + target.address);
  streams.Join();
}

}  // namespace palpate
