// The slave as the service sees it: commands in, states out. Tests of the service use a fake of it.
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
#include "slave/manipulator/driven_arm.h"
#include "slave/pipeline/sensing_pipeline.h"
#include "slave/scene/scene.h"

namespace palpate {

// What runs, for GetScene, GetCapabilities and `check`.
struct SlaveDescription {
  Scene scene;  // with the parameters now in force
  std::uint32_t settings_revision = 0;
  SenseInfo sense;
  bool simulated = false;
};

struct SlaveStatus {
  Phase phase = Phase::kReady;
  Validity validity = Validity::kFailed;
  std::uint64_t frames = 0, commands = 0, commands_refused = 0;
  double frame_rate = 0;  // [Hz], over the last second
  Time started_at{};
  std::vector<StageTimes> stages;
  std::vector<std::string> alarms;
  std::optional<ArmHealth> arm;         // nullopt: it exists only here
  std::optional<CameraHealth> cameras;  // nullopt: no images come live
};

// A change of SetParameters; absent: as it is.
struct ParameterChange {
  std::optional<double> position_scale, force_scale, force_limit, young_modulus;
};

// A surface around the contact, and what of it has changed since.
struct PatchSnapshot {
  std::shared_ptr<const SurfacePatch> patch;  // null: none
  PatchLaw law;
};

struct JpegPicture {
  Time sensed_at{};
  std::string jpeg;
  int width = 0, height = 0;
};

inline constexpr double kMaxPositionScale = 100, kMaxForceScale = 1e9;
// Of scales and the force limit, as of numbers in scenes: what they divide stays finite.
inline constexpr double kLeastSetting = 1e-15;

class TactileInbox;

class Slave {
 public:
  virtual ~Slave() = default;
  Slave() = default;
  Slave(const Slave&) = delete;
  Slave& operator=(const Slave&) = delete;

  // --- the operator. One at a time; the service holds the lease.
  // A lease begins: command sequences and epochs start anew, energies are zero, the tool stands
  // until engaged.
  virtual void BeginOperating() = 0;
  // Takes a command. False: refused, not finite, absurd or beyond the arm (it is counted and
  // flagged, the tool holds). Older than one already taken: dropped, true.
  virtual bool Command(const OperatorCommand& command) noexcept = 0;
  // The lease ends: the tool stands.
  virtual void EndOperating() = 0;

  // --- states. All thread-safe.
  // The newest state as of `now`, without sequence number and events: sent_at, echo and true force
  // are those of `now`.
  [[nodiscard]] virtual SlaveState Compose(Time now) = 0;
  // Events since the last call; one caller (the publisher).
  virtual Events TakeEvents() = 0;
  // Waits until something newer than `sensed_at` was sensed, or for `patience`; true: there is.
  virtual bool WaitForNewer(Time sensed_at, std::chrono::milliseconds patience) = 0;

  // Whether anybody reads states; somebody, until told otherwise. Who is not watched may rest, and
  // returns from SetWatched(true) awake. One caller (the publisher).
  virtual void SetWatched(bool /*is_watched*/) {}

  // --- settings and health. Throw std::invalid_argument (what is accepted) or std::logic_error
  // (not now, why). What makes a model tells `progress`, if there is one, and throws Interrupted
  // where it says so: everything is as it was then.
  [[nodiscard]] virtual SlaveDescription Describe() const = 0;
  [[nodiscard]] virtual SlaveStatus Status() const = 0;
  virtual void SetModel(const ModelChange& change, Progress* progress = nullptr) = 0;
  virtual void SetParameters(const ParameterChange& change, Progress* progress = nullptr) = 0;
  // Of an emergency stop; where there is none, finds anew.
  virtual void Reset() = 0;
  // The sense starts anew with its next sample: tip, template and rest. A stop stays.
  virtual void ReinitializeTracking() = 0;
  virtual void EmergencyStop(const std::string& reason) = 0;

  // --- bulk, computed only when asked for.
  [[nodiscard]] virtual BoundaryShape Shape(bool nodal_forces) = 0;
  // nullopt: the scene has no camera, or nothing was seen yet.
  [[nodiscard]] virtual std::optional<JpegPicture> Picture(bool overlays, int quality) = 0;

  // Of the samples after the one of `sensed_at`, the oldest first; of many, the newest.
  // Thread-safe.
  [[nodiscard]] virtual std::vector<SampleTrace> TracesSince(Time /*sensed_at*/) const {
    return {};
  }

  // The model of the contact as of now: kept up while it is asked for. Null: none is made.
  virtual PatchSnapshot Patch() { return {}; }

  // Where streamed tactile samples go; null: the scene takes none.
  [[nodiscard]] virtual TactileInbox* tactile_inbox() { return nullptr; }
  // Where streamed pictures go; null: the scene takes none.
  [[nodiscard]] virtual PictureInbox* picture_inbox() { return nullptr; }
  // The arm that a client drives; null: the scene's is none.
  [[nodiscard]] virtual DrivenArm* driven_arm() { return nullptr; }
};

}  // namespace palpate
