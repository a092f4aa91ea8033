// Runs the sensing of a slave, sample by sample, and holds the data that it shares with callers.
#pragma once

#include <atomic>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string_view>
#include <thread>
#include <vector>

#include <Eigen/Core>

#include "shared/link/priority_inheritance_mutex.h"
#include "slave/live/carried_model.h"
#include "slave/live/idle_throttle.h"
#include "slave/live/latest_estimate.h"
#include "slave/live/live_settings.h"
#include "slave/live/operator_port.h"
#include "slave/live/patch_publisher.h"
#include "slave/live/planned_depth.h"
#include "slave/manipulator/manipulator.h"
#include "slave/pipeline/base/sensing_pipeline.h"

namespace palpate {

class LiveSensing {
 public:
  // The objects that the sensing uses. They must outlive it.
  struct Parts {
    SensingPipeline& sense;
    PriorityInheritanceMutex& mutex;  // guards `sense`
    LiveSettings& settings;
    const Manipulator& manipulator;
    OperatorPort& port;
    LatestEstimate& newest;
  };

  // `shows_tool`: the samples show the tool that the manipulator carries.
  LiveSensing(const Scene& scene, const Parts& parts, bool shows_tool);
  ~LiveSensing() { Stop(); }
  LiveSensing(const LiveSensing&) = delete;
  LiveSensing& operator=(const LiveSensing&) = delete;

  // Estimates the first sample, if one is available. Throws std::runtime_error: no sample, or one
  // that cannot be used.
  void Begin();
  // Estimates the next sample, and publishes the result; on a driven clock it is at least the
  // sample's time now. False: the source has ended, there is no sample on a driven clock, or
  // `stop`. Throws std::runtime_error: the source breaks.
  bool Step(const std::stop_token& stop);
  // The two halves of a step.
  bool Acquire(const std::stop_token& stop);
  void Estimate();
  // Starts a thread that steps, sample by sample.
  void Start();
  // Ends the thread.
  void Stop();

  // Measures the baseline again with the next sample.
  void RequestReset();
  // From now on only one sample per half second is processed while no client watches. For sensing
  // that recovers its state in one sample.
  void AllowIdle() { throttle_.Allow(); }
  void SetWatched(bool is_watched);

  // The local model at the tip's present position. While a sample is being estimated it is that of
  // a moment ago.
  [[nodiscard]] LocalModel LocalNow();
  [[nodiscard]] const CarriedModel& local() const { return local_; }
  // The latest ones while a sample is being estimated, so that a status request does not wait.
  [[nodiscard]] std::vector<StageTimes> Stages() const;
  [[nodiscard]] PatchSnapshot Patch() { return patch_.Get(Clock::now()); }

 private:
  void Run(const std::stop_token& stop);
  // Logs the description of the sensing. A caller that steps the slave reads it itself.
  void ReportIntroduction() const;
  void ReportExtrapolation();
  // Raises an alarm if `auto` chose the model for contacts that are less deep.
  void ReportDepth(const ContactEstimate& estimate);

  [[nodiscard]] TipReading ReadEncoders(Time t) const;
  // Measures the difference of tip and encoders, which the operator's port uses.
  void Register(const ContactEstimate& estimate, const Eigen::Vector3d& p_S_encoders);
  // The description of the sensing is complete.
  void BeginRegistration();

  const Parts parts_;
  const bool shows_tool_;
  // Used by the thread; nullopt: the sensing does not measure a tip that the manipulator carries.
  std::optional<TipRegistration> registration_;
  std::set<std::string_view> reported_reasons_;  // already reported; each raises one alarm, once
  PlannedDepth planned_depth_;
  std::atomic<bool> reset_wanted_{false};
  SampleTrace trace_;  // of the acquired sample
  // The last measured tip and the encoder reading at that time, S [m]; under the sensing's mutex.
  Eigen::Vector3d p_S_sensed_, p_S_encoders_;
  bool has_estimate_ = false;                      // guarded by the mutex of the pipeline
  mutable PriorityInheritanceMutex stages_mutex_;  // guards the next one
  mutable std::vector<StageTimes> stages_;
  PatchPublisher patch_;  // updated under the sensing's mutex
  CarriedModel local_;
  IdleThrottle throttle_;
  std::jthread thread_;
};

}  // namespace palpate
