// Requests that signals make of the running program.
#pragma once

#include <atomic>

namespace palpate {

inline std::atomic<bool> g_stop{false}, g_emergency{false}, g_reset{false};
static_assert(std::atomic<bool>::is_always_lock_free);

// SIGINT, SIGTERM and SIGHUP end the session with the force at zero. SIGHUP stays ignored if the
// parent ignores it (nohup). SIGUSR1 requests the emergency stop, SIGUSR2 its reset. SIGPIPE is
// ignored: a closed pipe must not end the session.
void CatchSignals();

}  // namespace palpate
