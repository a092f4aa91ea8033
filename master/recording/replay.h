// A master's recording played as a session: whoever shows a live one is told the same, at the pace
// that is asked for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "master/haptics/record/tick_record.h"
#include "master/link/remote_mesh.h"
#include "shared/recording/mcap_bytes.h"
#include "shared/state/sample_trace.h"
#include "shared/state/slave_state.h"

namespace palpate {

namespace v1 {
class Capabilities;
class SceneDescription;
class Status;
}  // namespace v1

// Who is told; what nobody wants may be empty. All by the thread that plays.
struct ReplayFeed {
  std::function<void(const TickRecord&)> on_tick;
  std::function<void(const SlaveState&, Time received_at)> on_state;
  std::function<void(const std::string& jpeg, Time sensed_at)> on_picture;
  std::function<void(const std::shared_ptr<const RemoteMesh>&)> on_mesh;
  std::function<void(const SampleTrace&)> on_trace;
  std::function<void(const std::string& line, Time at, bool is_alarm)> on_log;
  // What the slave said of itself.
  std::function<void(const v1::SceneDescription&, Time at)> on_scene;
  std::function<void(const v1::Capabilities&, Time at)> on_capabilities;
  std::function<void(const v1::Status&, Time at)> on_health;
  // The recording's time so far and whether somebody wants it to go on; empty: it does. Asked
  // every 10 ms of the player's time.
  std::function<bool(double t)> goes_on;
};

struct ReplaySpan {
  Time first{}, last{};     // of what is recorded, recorder's clock
  std::uint64_t ticks = 0;  // of the haptic loop
  McapMap session;          // what it went by: version, target, device, ...
  std::string damage;       // what cannot be read, in words; empty: nothing
  [[nodiscard]] double seconds() const { return SecondsBetween(first, last); }
};

class Replay {
 public:
  static constexpr double kSlowest = 0.1, kFastest = 4;

  // Reads it through once. Throws InputError: not a recording, or none of a master's.
  explicit Replay(std::filesystem::path file);

  [[nodiscard]] const ReplaySpan& span() const { return span_; }
  // From `from` seconds after its beginning to its end, `speed` times as fast as it was; 0: as fast
  // as it goes. Throws InputError: a message is damaged.
  void Play(double from, double speed, const ReplayFeed& feed, const std::stop_token& stop) const;

 private:
  std::filesystem::path file_;
  ReplaySpan span_;
  std::shared_ptr<const MeshTopology> topology_;  // the first; null: no mesh was recorded
};

}  // namespace palpate
