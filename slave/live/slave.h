// Interface of the slave for the service: commands in, states out. Tests of the service use a fake.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shared/state/sample_trace.h"
#include "shared/state/slave_state.h"
#include "shared/state/surface_patch.h"
#include "slave/capture/frame_source.h"
#include "slave/manipulator/streamed_manipulator.h"
#include "slave/pipeline/base/sense_types.h"
#include "slave/scene/scene.h"

namespace palpate {

// Description for GetScene and `check`.
struct SlaveDescription {
  Scene scene;  // with the parameters now in force
  std::uint32_t settings_revision = 0;
  SenseInfo sense;
  bool simulated = false;  // sensors and manipulator: nothing real moves
  bool turns = false;      // the manipulator measures the tool's rotation
  std::string
      setup_camera;  // the keys of sense.camera for a set-up, one a line; empty: there is none
};

struct SlaveStatus {
  Phase phase = Phase::kReady;
  Validity validity = Validity::kFailed;
  std::uint64_t frames = 0, commands = 0, commands_refused = 0;
  std::uint64_t stops = 0;  // number of the newest emergency stop
  double frame_rate = 0;    // [Hz], over the last second
  Time started_at{};
  std::vector<StageTimes> stages;
  std::vector<std::string> alarms;
  std::optional<ArmHealth> arm;         // nullopt: it exists only here
  std::optional<CameraHealth> cameras;  // nullopt: no live images
};

// A change of SetParameters; absent: unchanged.
struct ParameterChange {
  std::optional<double> position_scale, force_scale, force_limit, young_modulus;
};

// A surface around the contact, and its changes since.
struct PatchSnapshot {
  std::shared_ptr<const SurfacePatch> patch;  // null: none
  PatchLaw law;
};

// An image as a JPEG file, with its size [px].
struct EncodedImage {
  Time sensed_at{};
  std::string jpeg;
  int width = 0, height = 0;
};

inline constexpr double kMaxPositionScale = 100, kMaxForceScale = 1e9;
// Limits of scales and the force limit, so that quotients stay finite.
inline constexpr double kMinSetting = 1e-15;

class ImageInbox;
class Progress;
class SceneSetup;
class TactileInbox;

class Slave {
 public:
  virtual ~Slave() = default;
  Slave() = default;
  Slave(const Slave&) = delete;
  Slave& operator=(const Slave&) = delete;

  // --- the operator. One at a time; the service manages the lease. When a lease begins, command
  // sequences and epochs start again, and the tool is stationary until engaged.
  virtual void BeginOperating() = 0;
  // Processes a command. False: rejected, because it is not finite, too large or beyond the
  // manipulator (it is counted and flagged, the tool holds). Older than an accepted one: dropped,
  // true.
  virtual bool Command(const OperatorCommand& command) noexcept = 0;
  // The lease ends: the tool is stationary.
  virtual void EndOperating() = 0;

  // --- states. All thread-safe. The newest state as of `now`, without sequence number and events:
  // sent_at, echo and true force are those of `now`.
  [[nodiscard]] virtual SlaveState Compose(Time now) = 0;
  // Events since the last call; one caller (the publisher).
  virtual Events TakeEvents() = 0;
  // Waits until something newer than `sensed_at` was sensed, or for `timeout`; true: there is.
  virtual bool WaitForNewer(Time sensed_at, std::chrono::milliseconds timeout) = 0;

  // Whether a client reads states; true until set. Without one the slave may idle, and is awake
  // again when SetWatched(true) returns. One caller (the publisher).
  virtual void SetWatched(bool is_watched) = 0;

  // --- settings and health. Throw std::invalid_argument with the accepted values, or
  // std::logic_error with the reason if a change is not possible now. Building a model reports to
  // `progress`, if there is one, and throws Interrupted without any change if it requests a stop.
  [[nodiscard]] virtual SlaveDescription Describe() const = 0;
  [[nodiscard]] virtual SlaveStatus Status() const = 0;
  virtual void SetModel(const ModelChange& change, Progress* progress = nullptr) = 0;
  virtual void SetParameters(const ParameterChange& change, Progress* progress = nullptr) = 0;
  // Clears the emergency stop number `stops`; without an active stop, reinitializes the tracking.
  // Throws std::logic_error too if another stop is active, which stays.
  virtual void Reset(std::uint64_t stops) = 0;
  // Measures tip, template and baseline again with the next sample. An emergency stop remains.
  virtual void ReinitializeTracking() = 0;
  // Stops the tool at once, without waiting.
  virtual void StopTool() noexcept = 0;
  // Records why the tool was stopped. It may wait for the disk. No effect after a reset.
  virtual void RecordStop(const std::string& reason) = 0;
  void EmergencyStop(const std::string& reason) {
    StopTool();
    RecordStop(reason);
  }

  // --- bulk data, computed only on request.
  [[nodiscard]] virtual BoundaryShape Shape(const ShapeParts& parts) = 0;
  // nullopt: the scene has no camera, or no image yet.
  [[nodiscard]] virtual std::optional<EncodedImage> Image(bool overlays, int quality) = 0;

  // Traces of the samples after the one of `sensed_at`, oldest first; the newest ones if there are
  // too many. Thread-safe.
  [[nodiscard]] virtual std::vector<SampleTrace> TracesSince(Time sensed_at) const = 0;

  // Returns the present local contact model. It is updated while it is requested. Null: none.
  virtual PatchSnapshot Patch() = 0;

  // Receiver of streamed tactile samples; null: none.
  [[nodiscard]] virtual TactileInbox* tactile_inbox() = 0;
  // Receiver of streamed images; null: none.
  [[nodiscard]] virtual ImageInbox* image_inbox() = 0;
  // The manipulator that a client drives; null: none.
  [[nodiscard]] virtual StreamedManipulator* driven_arm() = 0;
  // The set-up of another scene; null: none.
  [[nodiscard]] virtual SceneSetup* setup() = 0;
};

}  // namespace palpate
