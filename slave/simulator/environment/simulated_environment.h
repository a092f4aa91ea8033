// Interface of all simulators: a tool moves in it, and sources observe it.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/state/driven_clock.h"
#include "slave/capture/frame_source.h"
#include "slave/capture/ground_truth.h"
#include "slave/capture/sample_tap.h"
#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"

namespace palpate {

// Contacts without an operator.
struct ScriptedRun {
  double duration = 0;  // of a moving target [s]; 0: that of its path
  int presses = 1;      // contacts of fingertips
};

// Behaviour for a contact that is not solved yet: the tool waits, or must not be delayed.
enum class WhenUnsolved : std::uint8_t { kWait, kUseNearest };

// A source of simulated samples. In real time it returns one every 1 / rate seconds and skips late
// ones. With a script it returns them as fast as they are computed, with times from Time{}.
template <typename Source, typename Sample>
class SimulatedSource final : public Source {
 public:
  // Motion of the tool without an operator.
  struct Script {
    double duration = 0;               // [s]
    std::function<void(double)> move;  // brings the tool to where it is at a time [s]
    // Delay of a sample after its nominal time, relative to the period; empty: none.
    std::function<double(double)> delay{};
  };
  // `take` makes the sample of this moment, without its number and time.
  SimulatedSource(double rate, std::string description, std::function<Sample()> take,
                  std::optional<Script> script = std::nullopt)
      : rate_(rate),
        description_(std::move(description)),
        take_(std::move(take)),
        script_(std::move(script)) {}

  std::optional<Sample> Next(const std::stop_token& stop) override {
    const std::optional<Time> sensed_at = script_ ? FollowScript() : Wait(stop);
    if (!sensed_at || stop.stop_requested()) return std::nullopt;
    Sample sample = take_();
    sample.sensed_at = *sensed_at;
    sample.sequence = ++sequence_;
    return sample;
  }
  [[nodiscard]] std::string description() const override { return description_; }

 private:
  std::optional<Time> FollowScript() {
    double t = static_cast<double>(sequence_) / rate_;
    if (t > script_->duration) return std::nullopt;
    if (script_->delay) t += script_->delay(t) / rate_;
    script_->move(t);
    return Time{} + Seconds(t);
  }
  // The nominal times are kept if less than a period was lost. Sleeps in short stretches: a slow
  // source must not delay the end.
  std::optional<Time> Wait(const std::stop_token& stop) {
    const Clock::duration period(Seconds(1 / rate_));
    const Time now = Clock::now();
    due_ = due_ + 2 * period > now ? due_ + period : now;
    if (DrivenClock::Reach(due_)) return due_;
    while (!stop.stop_requested() && Clock::now() < due_) {
      const Time wake = std::min(due_, Clock::now() + std::chrono::milliseconds(50));
      std::this_thread::sleep_until(Clock::ToSteady(wake));
    }
    return Clock::now();
  }

  double rate_;  // [Hz]
  std::string description_;
  std::function<Sample()> take_;
  std::optional<Script> script_;
  Time due_{};
  std::uint64_t sequence_ = 0;
};

// Returns the true pose X_SO of a scene's object, including its misplacement.
inline Eigen::Isometry3d TruePose(const Scene& scene) {
  Eigen::Isometry3d X_SO = scene.object.X_SO;
  X_SO.translation().head<2>() += scene.site.misplacement;
  return X_SO;
}

// truth() is thread-safe.
class SimulatedEnvironment : public GroundTruth {
 public:
  // Moves the tool's tip here, S [m]. Thread-safe. Positions that are not finite are ignored. A
  // simulator is moved with one of both only.
  virtual void MoveTool(const Eigen::Vector3d& p_S_tip,
                        WhenUnsolved when_unsolved = WhenUnsolved::kWait) = 0;
  // Returns the offset of the tip from its script if a hand guides it (`site.hand`), at `t` [s]
  // after the start [m].
  [[nodiscard]] virtual Eigen::Vector3d HandOffset(double /*t*/) const {
    return Eigen::Vector3d::Zero();
  }
  // Solves the scene's contact before the start of operation. The tool is at home afterwards. Takes
  // seconds.
  virtual void SolveAhead() = 0;
  // Open sources of samples, one at a time; null: this kind does not exist. This object must
  // outlive them. `scene` is that of the simulator. With `run` the samples follow its script, as
  // fast as they are computed; without it they show the tool of MoveTool at the scene's rate. They
  // throw std::invalid_argument with the key if there is no script for it.
  virtual std::unique_ptr<FrameSource> OpenCamera(const Scene& /*scene*/,
                                                  const std::optional<ScriptedRun>& /*run*/) {
    return nullptr;
  }
  virtual std::unique_ptr<StereoSource> OpenPair(const Scene& /*scene*/,
                                                 const std::optional<ScriptedRun>& /*run*/) {
    return nullptr;
  }
  virtual std::unique_ptr<TactileSource> OpenFingertips(const Scene& /*scene*/,
                                                        const std::optional<ScriptedRun>& /*run*/) {
    return nullptr;
  }
};

// The simulator of the scene; null: it is a real environment. Throws std::invalid_argument naming
// the key if the scene cannot be simulated.
std::unique_ptr<SimulatedEnvironment> MakeSimulatedEnvironment(const Scene& scene);

}  // namespace palpate
