// A slave without images for tests of service, link and clients: a spring surface y = 0 and a tool
// that follows at once.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "slave/capture/image_inbox.h"
#include "slave/capture/tactile_inbox.h"
#include "slave/live/latest_estimate.h"
#include "slave/live/slave.h"
#include "slave/manipulator/streamed_manipulator.h"

namespace palpate {

class FakeSlave : public Slave {
 public:
  static constexpr double kStiffness = 1000;  // [N/m]
  static constexpr double kHome = 6e-3;       // the tool starts this high above the surface [m]

  FakeSlave();

  // --- for tests. Thread-safe. Simulates a new sample; a state is sent at once.
  void TakeSample();
  // The next states carry `event`.
  void Happen(Event event) { estimate_.Add(event); }
  [[nodiscard]] int begins() const { return Locked(begins_); }
  [[nodiscard]] int ends() const { return Locked(ends_); }
  [[nodiscard]] std::vector<OperatorCommand> commands() const {
    return Locked(commands_);
  }  // accepted since the last Begin
  [[nodiscard]] int shapes_computed() const { return Locked(shapes_); }
  [[nodiscard]] int reinitialized() const { return reinitialized_; }
  [[nodiscard]] int images_taken() const { return Locked(images_); }
  [[nodiscard]] std::string stop_reason() const { return Locked(stop_reason_); }
  [[nodiscard]] ParameterChange parameters() const { return Locked(parameters_); }
  // Making a model then takes until it is cancelled.
  void MakeModelsForEver() { makes_for_ever_ = true; }
  [[nodiscard]] bool is_making() const { return is_making_; }
  // Simulates a change of settings.
  void set_settings_revision(std::uint32_t revision) { Set(revision, &state_.settings_revision); }
  // From now on the scene has fingertips with streamed samples, each with the tool's force, and the
  // object is a triangle.
  void TakeTactile(const std::vector<std::string>& fingers);

  // From now on images of one grey camera of 64 x 48 px at 30 Hz are streamed.
  void TakeImages();
  // From now on the scene has no manipulator.
  void TakeNoManipulator() { Set(ManipulatorOptions::Source::kNone, &manipulator_); }
  void TakeScenes(SceneSetup* setup) { setup_ = setup; }
  // From now on a driver moves an arm, which the test commands by `arm()`.
  void TakeArm(const ManipulatorOptions& options);
  [[nodiscard]] StreamedManipulator& arm() { return *arm_; }

  // --- Slave.
  void BeginOperating() override;
  bool Command(const OperatorCommand& command) noexcept override;
  void EndOperating() override;
  SlaveState Compose(Time now) override;
  Events TakeEvents() override { return estimate_.TakeEvents(); }
  bool WaitForNewer(Time sensed_at, std::chrono::milliseconds timeout) override {
    return estimate_.WaitForNewer(sensed_at, timeout);
  }
  SlaveDescription Describe() const override;
  SlaveStatus Status() const override;
  // `bem2d` or empty is accepted; while following: std::logic_error.
  void SetModel(const ModelChange& change, Progress* progress = nullptr) override;
  void SetParameters(const ParameterChange& change, Progress* progress = nullptr) override;
  void Reset(std::uint64_t stops) override;
  void ReinitializeTracking() override { ++reinitialized_; }
  void StopTool() noexcept override;
  void RecordStop(const std::string& reason) override;
  std::vector<SampleTrace> TracesSince(Time sensed_at) const override {
    return estimate_.TracesSince(sensed_at);
  }
  BoundaryShape Shape(const ShapeParts& parts) override;
  std::optional<EncodedImage> Image(bool overlays, int quality) override;
  void SetWatched(bool /*is_watched*/) override {}
  PatchSnapshot Patch() override { return {}; }
  TactileInbox* tactile_inbox() override;
  ImageInbox* image_inbox() override { return pushed_.get(); }
  StreamedManipulator* driven_arm() override { return arm_.get(); }
  SceneSetup* setup() override { return setup_; }

 private:
  template <class T>
  T Locked(const T& value) const {
    const std::scoped_lock lock(mutex_);
    return value;
  }
  template <class T>
  void Set(T value, T* place) {
    const std::scoped_lock lock(mutex_);
    *place = value;
  }

  std::atomic<bool> makes_for_ever_{false}, is_making_{false};
  std::atomic<int> reinitialized_{0};
  LatestEstimate estimate_{30, {0, kHome, 0}};
  mutable std::mutex mutex_;  // guards everything below
  SlaveState state_;
  TeleopTransform transform_;
  Time command_at_{};
  Time started_at_ = Clock::now();
  std::vector<OperatorCommand> commands_;
  ParameterChange parameters_;
  std::string stop_reason_;
  std::uint64_t came_ = 0, refused_ = 0;
  int begins_ = 0, ends_ = 0, shapes_ = 0, images_ = 0;
  std::optional<Tactile> tactile_;
  std::unique_ptr<TactileInbox> inbox_;
  std::unique_ptr<ImageInbox> pushed_;
  std::unique_ptr<StreamedManipulator> arm_;
  std::atomic<SceneSetup*> setup_ = nullptr;
  ManipulatorOptions::Source manipulator_ = ManipulatorOptions::Source::kSimulated;
};

}  // namespace palpate
