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

#include "slave/capture/frame_source.h"
#include "slave/capture/ground_truth.h"
#include "slave/capture/pace.h"
#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"

namespace palpate {

// Whether a tool waits until its contact is solved, or must not be delayed.
enum class Patience : std::uint8_t { kWaits, kNone };

// Observes a simulator in real time: a sample every 1 / rate seconds; late ones are skipped.
template <typename Source, typename Sample>
class LiveSource final : public Source {
 public:
  // `take` makes the sample of this moment. Samples keep their raster as long as less than `slack`
  // periods were lost.
  LiveSource(double rate, double slack, std::string description, std::function<Sample(Time)> take)
      : period_(Seconds(1 / rate)),
        slack_(Seconds(slack / rate)),
        description_(std::move(description)),
        take_(std::move(take)) {}

  // Sleeps in short stretches: a slow source must not delay the end.
  std::optional<Sample> Next(const std::stop_token& stop) override {
    const Time now = Clock::now();
    due_ = due_ + period_ + slack_ > now ? due_ + period_ : now;
    while (!stop.stop_requested() && Clock::now() < due_) {
      const Time wake = std::min(due_, Clock::now() + std::chrono::milliseconds(50));
      std::this_thread::sleep_until(Clock::ToSteady(wake));
    }
    if (stop.stop_requested()) return std::nullopt;
    return take_(Clock::now());
  }
  [[nodiscard]] std::string description() const override { return description_; }

 private:
  Clock::duration period_, slack_;
  std::string description_;
  std::function<Sample(Time)> take_;
  Time due_{};
};

// Where the object of a scene really is, X_SO: its misplacement included.
inline Eigen::Isometry3d TruePose(const Scene& scene) {
  Eigen::Isometry3d X_SO = scene.object.X_SO;
  X_SO.translation().head<2>() += scene.site.misplacement;
  return X_SO;
}

// Its truth is thread-safe.
class SimulatedEnvironment : public GroundTruth {
 public:
  // Moves the tool's tip here, S [m]. Thread-safe. Positions that are not finite are ignored. A
  // simulator is moved with one patience only.
  virtual void MoveTool(const Eigen::Vector3d& p_S_tip, Patience patience = Patience::kWaits) = 0;
  // Solves the scene's contact before the start of operation; the tool is at home afterwards.
  // Seconds.
  virtual void SolveAhead() = 0;
  // Sources that observe this simulator, which must outlive them; one source at a time, null: this
  // kind does not exist. `scene`: that of the simulator. Throw std::invalid_argument naming the
  // key: there is no script for it.
  virtual std::unique_ptr<FrameSource> OpenCamera(const Scene& scene, const Pace& pace) = 0;
  virtual std::unique_ptr<StereoSource> OpenPair(const Scene& scene, const Pace& pace) = 0;
  virtual std::unique_ptr<TactileSource> OpenFingertips(const Scene& scene, const Pace& pace) = 0;
};

// The simulator of the scene; null: it is a real environment. Throws std::invalid_argument naming
// the key if the scene cannot be simulated.
std::unique_ptr<SimulatedEnvironment> MakeSimulatedEnvironment(const Scene& scene);

}  // namespace palpate
