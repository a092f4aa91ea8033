// `palpate-master connect`: operates a slave.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>

#include "master/commands/arguments.h"
#include "master/commands/connect_recorder.h"
#include "master/device/device.h"
#include "master/link/slave_link.h"

namespace palpate {

// Requests that signals make of the running program.
inline std::atomic<bool> g_stop{false}, g_emergency{false}, g_reset{false};
static_assert(std::atomic<bool>::is_always_lock_free);
// Requests the emergency stop. A reset that was requested before is no longer wanted.
inline void RequestEmergencyStop() noexcept {
  g_reset = false;
  g_emergency = true;
}

// SIGINT, SIGTERM and SIGHUP end the session with the force at zero. SIGHUP stays ignored if the
// parent ignores it (nohup). SIGUSR1 requests the emergency stop, SIGUSR2 its reset. SIGPIPE is
// ignored: a closed pipe must not end the session.
void CatchSignals();
// Time between looks whether a signal came.
inline constexpr std::chrono::milliseconds kSignalPoll(10);

// The link and the slots that must outlive it.
struct Line {
  explicit Line(const SlaveLink::Options& options) : link(options) {}
  LatestValue<ReceivedState> states;
  LatestValue<OperatorCommand> commands;
  LatestValue<RemoteSettings> settings;
  LatestValue<ReceivedPatch> patches;
  SlaveLink link;
};

// Runs the session until its end. Null `device`: one for the scene; null `recorder`: no recording.
// The exit code; throws std::runtime_error where the slave cannot be reached.
int Operate(const Arguments& a, Line* line, std::unique_ptr<Device> device,
            ConnectRecorder* recorder);

}  // namespace palpate
