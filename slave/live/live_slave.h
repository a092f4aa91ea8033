// The slave: an operator who moves a tool, a sensing that estimates its contact, and settings that
// change while it runs. It is independent of the kind of sensing, environment and manipulator.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "shared/link/priority_inheritance_mutex.h"
#include "slave/live/latest_estimate.h"
#include "slave/live/live_sensing.h"
#include "slave/live/live_settings.h"
#include "slave/live/operator_port.h"
#include "slave/live/slave.h"
#include "slave/live/stop_control.h"
#include "slave/live/stop_record.h"
#include "slave/manipulator/manipulator.h"
#include "slave/manipulator/played_manipulator.h"
#include "slave/pipeline/base/sense_recorder.h"
#include "slave/pipeline/base/sensing_pipeline.h"

namespace palpate {

// Threads: one senses, one moves the tool, one watches the operator. `sense_mutex_` guards the data
// that the first one shares with callers, except the latest estimate.
//
// With a driven clock it has none of these threads: the caller feeds samples and reports of the
// manipulator in the order of their times, and calls Step after each sample. Then the results are
// reproducible to the last digit.
class LiveSlave final : public Slave {
 public:
  // Estimates the first sample, if one is available, and starts. Throws std::runtime_error: no
  // sample, or one that cannot be used.
  LiveSlave(const Scene& scene, std::unique_ptr<Manipulator> manipulator,
            std::unique_ptr<SensingPipeline> sense);
  ~LiveSlave() override;

  // For a driven clock: processes the next sample and publishes the result. False: there is none.
  // Throws std::runtime_error: the source breaks.
  bool Step(const std::stop_token& stop);
  // The two halves of a step. Between them the caller plays the readings of the manipulator.
  bool Acquire(const std::stop_token& stop) { return sensing_.Acquire(stop); }
  ContactEstimate Estimate();
  // For a driven clock: watches the operator, as the slave's own thread does every 2 ms.
  void Watch() { watchdog_.Look(); }
  // For the thread that steps: the sensing, which reports of a run read in addition to the
  // published estimates.
  [[nodiscard]] SensingPipeline& sense() { return *sense_; }

  void BeginOperating() override { port_.BeginOperating(); }
  bool Command(const OperatorCommand& command) noexcept override;
  void EndOperating() override { port_.EndOperating(); }
  // Between samples the local model follows the device.
  [[nodiscard]] SlaveState Compose(Time now) override;
  Events TakeEvents() override;
  bool WaitForNewer(Time sensed_at, std::chrono::milliseconds timeout) override {
    return newest_.WaitForNewer(sensed_at, timeout);
  }
  [[nodiscard]] SlaveDescription Describe() const override;
  [[nodiscard]] SlaveStatus Status() const override;
  void SetModel(const ModelChange& change, Progress* progress = nullptr) override {
    settings_.SetModel(change, progress);
  }
  void SetParameters(const ParameterChange& change, Progress* progress = nullptr) override {
    settings_.SetParameters(change, progress);
  }
  void Reset(std::uint64_t stops) override;
  void ReinitializeTracking() override;
  void StopTool() noexcept override { port_.EmergencyStop(); }
  void RecordStop(const std::string& reason) override;
  // From now on an emergency stop is saved in `folder`, and a saved one is active. Throws
  // std::runtime_error: the folder is not writable.
  void KeepStopIn(const std::filesystem::path& folder);
  [[nodiscard]] BoundaryShape Shape(const ShapeParts& parts) override;
  [[nodiscard]] std::optional<EncodedImage> Image(bool overlays, int quality) override;
  void SetWatched(bool is_watched) override { sensing_.SetWatched(is_watched); }
  // From now on the status has the alarm of the recording. `recorder` outlives the slave. Before
  // the slave is served.
  void ReportRecorder(const SenseRecorder* recorder) { recorder_ = recorder; }
  // From now on only one sample per half second is processed while no client watches. For sensing
  // that recovers its state in one sample.
  void AllowIdle() { sensing_.AllowIdle(); }
  [[nodiscard]] std::vector<SampleTrace> TracesSince(Time sensed_at) const override {
    return newest_.TracesSince(sensed_at);
  }
  PatchSnapshot Patch() override { return sensing_.Patch(); }
  [[nodiscard]] TactileInbox* tactile_inbox() override { return sense_->inbox(); }
  [[nodiscard]] ImageInbox* image_inbox() override { return sense_->image_inbox(); }
  [[nodiscard]] StreamedManipulator* driven_arm() override { return manipulator_->driven(); }
  [[nodiscard]] SceneSetup* setup() override { return setup_; }
  // From now on a client may set up another scene by `setup`, which outlives the slave. `camera`:
  // SlaveDescription::setup_camera. Before the slave is served.
  void OfferSetup(SceneSetup* setup, std::string camera);
  // Continues the revisions of a former slave with the revision `former`: that of this slave
  // becomes greater. Call before the slave is served.
  void ContinueRevisions(std::uint32_t former) { settings_.ContinueRevisions(former); }

 private:
  [[nodiscard]] ContactState ContactStateNow() const;
  // Without a scene the phase is that of a set-up.
  [[nodiscard]] Phase Shown(Phase phase) const {
    return !has_scene_ && phase == Phase::kObserving ? Phase::kSetup : phase;
  }

  const Time started_at_ = Clock::now();
  const bool has_scene_;
  SceneSetup* setup_ = nullptr;
  const SenseRecorder* recorder_ = nullptr;  // null: no recording
  std::string setup_camera_;
  const std::unique_ptr<Manipulator> manipulator_;
  const std::unique_ptr<SensingPipeline> sense_;
  OperatorPort port_;
  LatestEstimate newest_;
  StopRecord stop_record_;
  StopControl stop_control_{port_, stop_record_};

  // Inherits priority, because a request for a shape holds it while the sensing waits.
  mutable PriorityInheritanceMutex sense_mutex_;
  LiveSettings settings_;
  LiveSensing sensing_;

  CommandWatchdog watchdog_;
};

// Creates the slave of the scene with manipulator and sensing. The samples of simulated sensors
// come from palpate-simulator, see StreamSimulated. Throws the same exceptions. `state_folder`: see
// KeepStopIn; empty: an emergency stop ends with the process. `recorder`: of the sensing, outlives
// the slave; null: none. `open`, `progress`: see SenseInputs.
std::unique_ptr<LiveSlave> MakeLiveSlave(Scene scene,
                                         const std::filesystem::path& state_folder = {},
                                         SenseRecorder* recorder = nullptr,
                                         const FrameOpener& open = {},
                                         Progress* progress = nullptr);
// The slave of samples that `player`, which outlives it, plays on a driven clock, with the
// manipulator's readings at them.
std::unique_ptr<LiveSlave> MakePlayedSlave(const Scene& scene, SamplePlayer& player,
                                           std::unique_ptr<PlayedManipulator> manipulator);
// Creates the slave of a set-up, which only shows images. `camera`: the camera that `open` opens.
std::unique_ptr<LiveSlave> MakePreviewSlave(const Camera& camera, const FrameOpener& open);

}  // namespace palpate
