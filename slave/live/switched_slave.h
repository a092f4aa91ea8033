// A slave whose scene is replaced while it serves: during the set-up another slave takes its place.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "shared/link/priority_inheritance_mutex.h"
#include "slave/live/slave.h"

namespace palpate {

// Revisions of the settings keep rising over a replacement.
class SwitchedSlave final : public Slave {
 public:
  // `first` has no scene yet. `camera_lines`: SlaveDescription::setup_camera. `setup` outlives it.
  SwitchedSlave(std::shared_ptr<Slave> first, std::string camera_lines, SceneSetup* setup)
      : camera_lines_(std::move(camera_lines)), setup_(setup), now_{std::move(first), 0, true} {}

  // From now on `next` serves. Nobody operates. An emergency stop stays.
  void Replace(std::shared_ptr<Slave> next) {
    const Present before = present();
    const std::uint32_t revision = before.base + before.slave->Describe().settings_revision;
    if (before.slave->Status().phase == Phase::kEstop) next->EmergencyStop("before the new scene");
    next->SetWatched(is_watched_);
    const std::lock_guard lock(mutex_);
    now_ = {std::move(next), revision, false};
  }

  void BeginOperating() override { present().slave->BeginOperating(); }
  bool Command(const OperatorCommand& command) noexcept override {
    const Present now = present();
    OperatorCommand passed = command;
    if (command.settings_revision != 0) passed.settings_revision -= now.base;
    return now.slave->Command(passed);
  }
  void EndOperating() override { present().slave->EndOperating(); }
  [[nodiscard]] SlaveState Compose(Time now) override {
    const Present at = present();
    SlaveState state = at.slave->Compose(now);
    state.settings_revision += at.base;
    if (at.is_first && state.phase == Phase::kObserving) state.phase = Phase::kSetup;
    return state;
  }
  Events TakeEvents() override { return present().slave->TakeEvents(); }
  bool WaitForNewer(Time sensed_at, std::chrono::milliseconds patience) override {
    return present().slave->WaitForNewer(sensed_at, patience);
  }
  void SetWatched(bool is_watched) override {
    is_watched_ = is_watched;
    present().slave->SetWatched(is_watched);
  }
  [[nodiscard]] SlaveDescription Describe() const override {
    const Present now = present();
    SlaveDescription description = now.slave->Describe();
    description.settings_revision += now.base;
    description.setup_camera = camera_lines_;
    return description;
  }
  [[nodiscard]] SlaveStatus Status() const override {
    const Present now = present();
    SlaveStatus status = now.slave->Status();
    if (now.is_first && status.phase == Phase::kObserving) status.phase = Phase::kSetup;
    return status;
  }
  void SetModel(const ModelChange& change, Progress* progress) override {
    present().slave->SetModel(change, progress);
  }
  void SetParameters(const ParameterChange& change, Progress* progress) override {
    present().slave->SetParameters(change, progress);
  }
  void Reset(std::uint64_t stops) override { present().slave->Reset(stops); }
  void ReinitializeTracking() override { present().slave->ReinitializeTracking(); }
  void EmergencyStop(const std::string& reason) override { present().slave->EmergencyStop(reason); }
  [[nodiscard]] BoundaryShape Shape(bool nodal_forces) override {
    return present().slave->Shape(nodal_forces);
  }
  [[nodiscard]] std::optional<JpegPicture> Picture(bool overlays, int quality) override {
    return present().slave->Picture(overlays, quality);
  }
  [[nodiscard]] std::vector<SampleTrace> TracesSince(Time sensed_at) const override {
    return present().slave->TracesSince(sensed_at);
  }
  PatchSnapshot Patch() override { return present().slave->Patch(); }
  // A set-up has one camera, and no manipulator that a client drives.
  [[nodiscard]] TactileInbox* tactile_inbox() override { return nullptr; }
  [[nodiscard]] PictureInbox* picture_inbox() override { return nullptr; }
  [[nodiscard]] StreamedManipulator* driven_arm() override { return nullptr; }
  [[nodiscard]] SceneSetup* setup() override { return setup_; }

 private:
  struct Present {
    std::shared_ptr<Slave> slave;
    std::uint32_t base = 0;  // revision before its first one
    bool is_first = false;   // without a scene
  };
  [[nodiscard]] Present present() const {
    const std::lock_guard lock(mutex_);
    return now_;
  }

  const std::string camera_lines_;
  SceneSetup* const setup_;
  std::atomic<bool> is_watched_ = true;
  mutable PriorityInheritanceMutex mutex_;  // guards the next one; never locked long
  Present now_;
};

}  // namespace palpate
