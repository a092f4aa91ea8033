// Plays a master's recording like a live session, at the requested speed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "master/haptics/tick_record.h"
#include "master/link/remote_mesh.h"
#include "shared/recording/mcap_bytes.h"
#include "shared/state/sample_trace.h"
#include "shared/state/slave_state.h"

namespace palpate {

namespace v1 {
class Capabilities;
class SceneDescription;
class SlaveState;
class Status;
}  // namespace v1

// Callbacks of a replay. Each may be empty. All are called on the playing thread.
struct ReplayFeed {
  std::function<void(const TickRecord&)> on_tick;
  std::function<void(const SlaveState&, const v1::SlaveState& message)> on_state;
  std::function<void(const std::string& jpeg, Time sensed_at)> on_image;
  std::function<void(const std::shared_ptr<const RemoteMesh>&)> on_mesh;
  std::function<void(const SampleTrace&)> on_trace;
  std::function<void(const std::string& line, Time at, bool is_alarm)> on_log;
  // Messages of the slave about scene and status.
  std::function<void(const v1::SceneDescription&, Time at)> on_scene;
  std::function<void(const v1::Status&, Time at)> on_health;
  // Called every 10 ms of real time with the time in the recording; returns whether to continue.
  // May be empty.
  std::function<bool(double t)> goes_on;
};

struct ReplaySpan {
  Time first{}, last{};     // of the recorded data, recorder's clock
  std::uint64_t ticks = 0;  // of the haptic loop
  McapMap session;          // its settings: version, target, device, ...
  std::string damage;       // unreadable parts, as text; empty: none
  [[nodiscard]] double seconds() const { return SecondsBetween(first, last); }
};

class Replay {
 public:
  static constexpr double kSlowest = 0.1, kFastest = 4;

  // Reads the whole file once. Throws InputError if it is no recording of a master.
  explicit Replay(std::filesystem::path file);

  [[nodiscard]] const ReplaySpan& span() const { return span_; }
  // Plays from `from` [s] after the start to the end, at `speed` times real time; 0: without
  // waiting. Throws InputError if a message is damaged.
  void Play(double from, double speed, const ReplayFeed& feed, const std::stop_token& stop) const;

 private:
  std::filesystem::path file_;
  ReplaySpan span_;
  std::shared_ptr<const MeshTopology> topology_;  // the first; null: no recorded mesh
};

}  // namespace palpate
