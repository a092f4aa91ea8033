// A whole run: haptic loop, bare loops beside it, the slow thread that records and shows, and what
// it all came to.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "master/haptics/haptic_loop.h"
#include "master/haptics/periodic.h"
#include "master/haptics/record/recorder.h"
#include "master/haptics/record/tick_summary.h"
#include "master/haptics/stop_path.h"

namespace palpate {

// One of several fingertips.
struct FingerReport {
  std::string name;
  double contact_share = 0;  // of the run's ticks that it touched [-]
  double force_peak = 0;     // largest estimated force, S [N]
};

// The object's surface, where somebody watched it.
struct ShapeReport {
  std::uint64_t meshes = 0;    // that came
  double deflection_peak = 0;  // [m]
};

// A run in numbers. Times [s] unless named, forces [N].
struct Report {
  std::string scene, model, device, render, realtime;  // in words
  double duration = 0;
  std::uint64_t ticks = 0, missed = 0;
  std::array<std::uint64_t, BareLoops::kCount> bare_missed{};  // sorted
  LatencyHistogram wake_us, compute_us;
  LinkStats link;
  double force_peak = 0;       // S: largest true force, else largest estimated
  bool truth_known = false;    // the site told its true force
  double force_sent_peak = 0;  // M
  std::optional<ForceError::Summary> force_error;
  std::uint64_t let_go_ticks = 0;  // of them, see TickSummary
  std::optional<TickSummary::DelayCompensated> force_error_delay_compensated;
  std::optional<TickSummary::Breaking> breaking;  // apart from both; nothing: no membrane broke
  PatchWatch::Stats patch;                        // what came of the model that travels
  std::vector<FingerReport> fingers;              // empty: one tool
  std::optional<ShapeReport> shape;
  double energy_min = 0;  // of the passivity control's balance [J]
  double work_min = 0;    // least of what the hand had put in less what it had got [J]
  std::uint64_t clamped_ticks = 0, stale_ticks = 0, records_dropped = 0;
  std::uint32_t epochs = 0;
  OperatorState state = OperatorState::kDisconnected;  // at the end
  std::map<std::string, double> seconds_in;            // operator state: time in it
  std::map<std::string, std::uint64_t> reasons;        // reason: ticks
  std::vector<std::string> trouble;                    // what went wrong, in words
  bool log_failed = false;                             // rows are missing

  [[nodiscard]] double rate() const {
    return duration > 0 ? static_cast<double>(ticks) / duration : 0;
  }
  [[nodiscard]] std::uint64_t bare_median() const { return bare_missed[bare_missed.size() / 2]; }
};

// report.json, what contracts promise and more: as JSON text, numbers finite.
std::string ToJson(const Report& report);
// Writes it whole or not at all. Throws std::runtime_error: it cannot be written.
void WriteReport(const Report& report, const std::filesystem::path& file);

// A fingertip, or the tool of a scene without several, as of the newest state.
struct NamedFinger {
  std::string name;
  FingerState felt;
};

// Of the newest state. Fingertips that `names` lacks are numbered.
std::vector<NamedFinger> Named(const TickRecord& record, const std::vector<std::string>& names);

// What the operator sees while it runs.
struct Status {
  double t = 0;  // [s] since the run began
  TickRecord tick;
  double rate = 0;                   // ticks per second over the last while [Hz]
  double force_limit = 0;            // [N]
  std::vector<NamedFinger> fingers;  // in the scene's order; empty: no state yet
  LinkStats link;
  std::string badge = {};  // that goes before it all: `REPLAY`; empty: this is live
};

struct SessionOptions {
  HapticLoop::Options loop;
  LatestValue<RemoteSettings>* settings = nullptr;  // outlives the run; null: they never change
  LatestValue<ReceivedPatch>* patches = nullptr;    // outlives the run; null: none comes
  std::function<PatchWatch::Stats()> patch_stats;   // asked at the end; empty: none
  StopPath::Ways emergency;                         // empty: nobody asks for a stop
  Recorder::Onlooker see_tick;            // every tick, on the calling thread; empty: nobody
  std::vector<std::string> finger_names;  // in the scene's order; those it lacks are numbered
  double duration = 0;        // [s]; 0: until stopped, or until the device's motion is over
  std::filesystem::path log;  // empty: none
  const OperatorRequests* requests = nullptr;  // outlives the run; null: nobody asks
};

// Runs with the calling thread as the slow one. `stop_wanted` is asked every 10 ms, `show` called
// ten times a second. The device has zero force and the slave a command to stand when it returns.
// Throws std::runtime_error: the log cannot be written at the start.
Report RunSession(const SessionOptions& options, Device& device, LatestValue<ReceivedState>* states,
                  LatestValue<OperatorCommand>* commands, const std::function<LinkStats()>& link,
                  const std::function<bool()>& stop_wanted,
                  const std::function<void(const Status&)>& show);

}  // namespace palpate
