// A whole run: haptic loop, the slow thread that records and displays, and the report.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "master/haptics/haptic_loop.h"
#include "master/haptics/periodic.h"
#include "master/haptics/stop_path.h"
#include "master/link/slave_link.h"
#include "master/session/recorder.h"
#include "master/session/tick_summary.h"

namespace palpate {

// FingerReport summarises one of several fingertips.
struct FingerReport {
  std::string name;
  double contact_share = 0;  // share of ticks in contact [-]
  double force_peak = 0;     // largest estimated force, S [N]
};

// The object's surface, if it was watched.
struct ShapeReport {
  std::uint64_t meshes = 0;    // received
  double deflection_peak = 0;  // [m]
};

// Results of a run. Times [s] unless named, forces [N].
struct Report {
  std::string scene, model, device, render, realtime;  // text
  double duration = 0;
  std::uint64_t ticks = 0, missed = 0;
  LatencyHistogram wake_us, compute_us;
  LinkStats link;
  double force_peak = 0;       // S: largest true force, else largest estimated
  bool truth_known = false;    // the slave reported a true force
  double force_sent_peak = 0;  // M
  std::optional<ForceError::Summary> force_error;
  std::uint64_t let_go_ticks = 0;  // part of force_error, see TickSummary
  std::optional<TickSummary::DelayCompensated> force_error_delay_compensated;
  std::optional<TickSummary::Breaking> breaking;  // excluded from both; empty without a puncture
  PatchStats patch;                               // received patches
  std::vector<FingerReport> fingers;              // empty: one tool
  std::optional<ShapeReport> shape;
  double energy_min = 0;  // least balance of the passivity control [J]
  double work_min = 0;    // minimum of the energy from the operator minus the energy returned [J]
  std::uint64_t clamped_ticks = 0, stale_ticks = 0, records_dropped = 0;
  std::uint32_t epochs = 0;
  OperatorState state = OperatorState::kDisconnected;  // at the end
  std::map<std::string, double> seconds_in;            // operator state: time in it
  std::map<std::string, std::uint64_t> reasons;        // reason: ticks
  std::vector<std::string> trouble;                    // problems, as text
  bool log_failed = false;                             // rows are missing

  [[nodiscard]] double rate() const {
    return duration > 0 ? static_cast<double>(ticks) / duration : 0;
  }
};

// The content of report.json, with finite numbers.
std::string ToJson(const Report& report);
// Writes the whole file or nothing. Throws std::runtime_error if it cannot write.
void WriteReport(const Report& report, const std::filesystem::path& file);

// A fingertip or the single tool, in the newest state.
struct NamedFinger {
  std::string name;
  FingerState contact;
};

// Fingertips of the newest state. Those without a name in `names` are numbered.
std::vector<NamedFinger> Named(const TickRecord& record, const std::vector<std::string>& names);

// Status of a running session, for the operator.
struct SessionStatus {
  double t = 0;  // [s] since the run began
  TickRecord tick;
  double rate = 0;                   // recent ticks per second [Hz]
  double force_limit = 0;            // [N]
  std::vector<NamedFinger> fingers;  // in the scene's order; empty: no state yet
  LinkStats link;
  std::string badge = {};   // `REPLAY`; empty: live
  std::string device = {};  // its description; empty: a recording
};

struct SessionOptions {
  HapticLoop::Options loop;
  LatestValue<RemoteSettings>* settings = nullptr;  // must outlive the run; null: fixed settings
  LatestValue<ReceivedPatch>* patches = nullptr;    // must outlive the run; null: no patches
  std::function<PatchStats()> patch_stats;          // called at the end; may be empty
  StopPath::Ways emergency;                         // may be empty
  Recorder::TickObserver on_tick;  // called for every tick on the calling thread; may be empty
  std::vector<std::string>
      finger_names;           // in the scene's order; fingertips without a name are numbered
  double duration = 0;        // [s]; 0: until stopped, or until the device's motion is over
  std::filesystem::path log;  // empty: none
  const OperatorRequests* requests = nullptr;  // must outlive the run; null: no requests
  double sensor_rate = 0;                      // of the slave [Hz]; 0: unknown
  // Called with sentences for the operator on the calling thread; may be empty.
  std::function<void(const std::string&)> notify;
};

// Runs a session. The calling thread is the slow one: it calls `stop_wanted` every 10 ms and `show`
// ten times a second. On return the force is zero and the slave has a command to stop the tool.
// Throws std::runtime_error if the log cannot be opened.
Report RunSession(const SessionOptions& options, Device& device, LatestValue<ReceivedState>* states,
                  LatestValue<OperatorCommand>* commands, const std::function<LinkStats()>& link,
                  const std::function<bool()>& stop_wanted,
                  const std::function<void(const SessionStatus&)>& show);

}  // namespace palpate
