// The slave: an operator who moves a tool, a sense that feels what it touches, settings that change
// while it runs. Which sense, which site and which arm, it does not know.
#pragma once

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "shared/link/priority_inheritance_mutex.h"
#include "slave/manipulator/manipulator.h"
#include "slave/pipeline/local_model/patch_publisher.h"
#include "slave/pipeline/sense_recorder.h"
#include "slave/pipeline/sensing_pipeline.h"
#include "slave/pipeline/teleop/image_latency_estimator.h"
#include "slave/pipeline/teleop/latest_estimate.h"
#include "slave/pipeline/teleop/model_validity_monitor.h"
#include "slave/pipeline/teleop/operator_port.h"
#include "slave/pipeline/teleop/slave.h"
#include "slave/pipeline/teleop/stop_record.h"
#include "slave/site/simulated_environment.h"

namespace palpate {

// The scene with the model that `kind: auto` takes for it; it may take seconds. nullopt: no model
// answers with a known error. Throws as MakeModel does.
using ModelChooser = std::function<std::optional<Scene>(const Scene&, const std::stop_token&)>;

// Threads: one senses, one moves the tool, one watches the operator, one chooses another model when
// auto's no longer holds. `sense_mutex_` guards what the first one shares with callers beyond the
// latest estimate.
class LiveSlave final : public Slave {
 public:
  // Feels the first sample, where one comes by itself, and starts. `environment`: that in which
  // `sense` senses and `manipulator` moves; null: the real one. Throws std::runtime_error: nothing
  // came, or what cannot be used. `choose`: asked again where what it decided for `scene` turns out
  // not to hold; empty: that is never looked at.
  LiveSlave(const Scene& scene, std::unique_ptr<SimulatedEnvironment> environment,
            std::unique_ptr<Manipulator> manipulator, std::unique_ptr<SensingPipeline> sense,
            const ModelChooser& choose = {});
  ~LiveSlave() override;

  void BeginOperating() override { port_.BeginOperating(); }
  bool Command(const OperatorCommand& command) noexcept override;
  void EndOperating() override { port_.EndOperating(); }
  // The local model follows the hand between samples.
  [[nodiscard]] SlaveState Compose(Time now) override;
  Events TakeEvents() override;
  bool WaitForNewer(Time sensed_at, std::chrono::milliseconds patience) override {
    return newest_.WaitForNewer(sensed_at, patience);
  }
  [[nodiscard]] SlaveDescription Describe() const override;
  [[nodiscard]] SlaveStatus Status() const override;
  void SetModel(const ModelChange& change, Progress* progress = nullptr) override;
  void SetParameters(const ParameterChange& change, Progress* progress = nullptr) override;
  void Reset() override;
  void ReinitializeTracking() override;
  void EmergencyStop(const std::string& reason) override;
  // An emergency stop is kept in `folder` from now on, and one that is kept there holds. Throws
  // std::runtime_error: nothing can be kept there.
  void KeepStopIn(const std::filesystem::path& folder);
  [[nodiscard]] BoundaryShape Shape(bool nodal_forces) override;
  [[nodiscard]] std::optional<JpegPicture> Picture(bool overlays, int quality) override;
  void SetWatched(bool is_watched) override;
  // From now on, while nobody watches, a sample is taken every half second only. For a sense that
  // finds again in one sample what it knew before.
  void AllowRest() { may_rest_ = true; }
  [[nodiscard]] std::vector<SampleTrace> TracesSince(Time sensed_at) const override {
    return newest_.TracesSince(sensed_at);
  }
  PatchSnapshot Patch() override { return patch_.Get(Clock::now()); }
  [[nodiscard]] TactileInbox* tactile_inbox() override { return sense_->inbox(); }
  [[nodiscard]] PictureInbox* picture_inbox() override { return sense_->pictures(); }
  [[nodiscard]] DrivenArm* driven_arm() override { return manipulator_->driven(); }

 private:
  void Sensing(const std::stop_token& stop);
  // Waits for somebody who watches, or for the time of the next sample that nobody does.
  void Rest(const std::stop_token& stop);
  // One sample; false: the source has ended.
  bool ProcessSample(const std::stop_token& stop);
  void Register(const ContactEstimate& felt, const Eigen::Vector3d& p_S_encoders);
  void HoldAgainstArm(const Eigen::Vector3d& p_S_arm, ContactEstimate* felt) noexcept;
  void ReportExtrapolation();
  // The sense has its first sample and knows what it is.
  void ReadSenseInfo();
  [[nodiscard]] LocalModel LocalNow();
  [[nodiscard]] std::optional<Eigen::Vector3d> TrueForce() const;
  void Rebuild(const Scene& changed, Progress* progress);
  void Adopt(const Scene& changed, std::unique_ptr<PreparedModel> prepared);
  // What `choose` says now takes the model's place as soon as settings may change, and not before:
  // under a hand that follows or touches, force and stiffness would jump. Returns what came of it.
  std::string RechooseModel(double depth, const ModelChooser& choose, const std::stop_token& stop);
  // False: not now. Settings of another revision drop it.
  bool TryAdopt(const Scene& changed, std::uint32_t revision,
                std::unique_ptr<PreparedModel>* prepared);
  void RefuseUnlessFree() const;
  [[nodiscard]] Scene scene() const;  // with the parameters now in force
  [[nodiscard]] ContactState ContactStateNow() const;
  // By the newest local model, which knows nothing of places far aside.
  void CarryOn(ContactState* contact) const;
  [[nodiscard]] std::vector<StageTimes> StagesNow() const;
  // The largest force that the hand can show, at the tool [N].
  [[nodiscard]] double FullScale() const;

  const Time started_at_ = Clock::now();
  const std::unique_ptr<SimulatedEnvironment> environment_;
  const std::unique_ptr<Manipulator> manipulator_;
  const std::unique_ptr<SensingPipeline> sense_;
  const bool shows_arm_;                 // a real one, in live pictures
  ImageLatencyEstimator image_latency_;  // the sensing thread's
  OperatorPort port_;
  LatestEstimate newest_;
  std::optional<TipRegistration>
      tip_registration_;                    // the sensing thread's; none: nothing to measure
  std::set<std::string_view> told_doubts_;  // likewise; an alarm each, once
  std::atomic<bool> reset_wanted_{false};
  std::atomic<std::uint32_t> settings_revision_{1};
  StopRecord stop_record_;

  std::mutex change_mutex_;  // one change of settings at a time; held while a model is made
  mutable std::mutex settings_mutex_;  // never held long; guards the next two
  Scene scene_;                        // with the parameters in force
  SenseInfo sense_info_;

  // Urgent: whoever asks for a shape holds it for as long as that takes, and sensing waits.
  mutable PriorityInheritanceMutex sense_mutex_;
  // The tip when it was last sensed, and what the arm said then, S [m]; under sense_mutex_.
  Eigen::Vector3d p_S_sensed_, p_S_encoders_;
  mutable std::mutex stages_mutex_;  // guards the next one
  mutable std::vector<StageTimes> stages_;
  PatchPublisher patch_;                          // updated under sense_mutex_
  mutable PriorityInheritanceMutex local_mutex_;  // guards the next three
  LocalModel newest_local_;
  // A place of the tip that it goes by, and what the arm said there, S [m].
  Eigen::Vector3d p_S_local_{0, 0, 0}, p_S_local_arm_{0, 0, 0};

  std::atomic<bool> may_rest_{false};
  std::mutex rest_mutex_;  // guards the next two
  std::condition_variable_any roused_;
  bool is_watched_ = true;

  std::optional<CommandWatchdog> watchdog_;
  std::optional<ModelValidityMonitor>
      model_validity_;  // nullopt: the scene's model was not auto's choice
  std::jthread sensing_;
};

// The slave of the scene: its site, its arm and its sense. Throws as they do. `state_folder`: see
// KeepStopIn; empty: an emergency stop ends with the process. `recorder`: of the sense, outlives
// the slave; null: nobody. `choose`: see LiveSlave.
std::unique_ptr<Slave> MakeLiveSlave(const Scene& scene,
                                     const std::filesystem::path& state_folder = {},
                                     SenseRecorder* recorder = nullptr,
                                     const ModelChooser& choose = {});

}  // namespace palpate
