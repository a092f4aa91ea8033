// The link to the slave: connects, keeps one Operate stream open, measures it and reconnects. The
// haptic loop uses only its latest-value slots.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "master/haptics/received.h"
#include "master/link/remote_scene.h"
#include "shared/link/latest_value.h"
#include "shared/state/slave_state.h"

namespace palpate {

struct LinkStats {
  bool connected = false;
  std::uint64_t states = 0, commands = 0, reconnects = 0;
  std::uint64_t refused = 0;  // states rejected as invalid
  double rtt_p50_us = 0, rtt_p99_us = 0, rtt_max_us = 0;
  double clock_offset = 0;  // [s]
  // Why it is not connected, who has the lease, why the last state was rejected, or that no
  // datagrams arrive; empty: no problem.
  std::string trouble;
  bool answers =
      false;  // while not connected: the slave answers and states why it rejects the call
  bool observes = false;  // the slave has no manipulator, or no scene yet: nobody can operate
  std::uint64_t states_by_datagram = 0;  // states received first by datagram
  // Times across both clocks. `delay` and `age`: of states at arrival, since sending and since
  // sensing. `command_age`: of the newest command when the slave sent a state.
  struct Times {
    double p50_us = 0, p99_us = 0, max_us = 0;
  } delay, age, command_age;
};

class SlaveLink {
 public:
  struct Options {
    std::string target;         // HOST:PORT
    double wait = 10;           // time limit of Connect [s]
    bool insecure = false;      // allow targets that are not loopback, in plain text
    std::filesystem::path tls;  // folder with the certificates; empty: plain text
    std::string operator_name;
    std::chrono::milliseconds longest_round_trip{1000};  // accepted at least
    // Called for each received state and each sent command on the link's threads. They must not
    // keep the references. May be empty.
    std::function<void(const ReceivedState&)> on_received = {};
    std::function<void(const OperatorCommand&)> on_sent = {};
    // Also send states and commands by datagram, so that a lost packet causes no delay. Empty: only
    // to another machine, because loopback loses nothing and may be the end of a TCP tunnel.
    std::optional<bool> datagrams = {};
  };
  // Throws std::invalid_argument for an invalid target, or one beyond loopback without `insecure`.
  explicit SlaveLink(Options options);
  ~SlaveLink();

  // Connects, with retries during `wait`. Throws std::runtime_error with the attempts if no slave
  // answers, or if it is incompatible. Links with a round trip of seconds are given enough time.
  RemoteScene Connect();
  // The longest round trip that the link needs, measured by Connect.
  [[nodiscard]] std::chrono::milliseconds longest_round_trip() const;
  // Opens the Operate stream and keeps it open, reconnecting with back-off, until Stop. Sends from
  // `commands` 500 times a second and puts received states into `states`. Puts settings into
  // `settings` before each stream and after each change. All three must outlive the link.
  void Start(LatestValue<ReceivedState>* states, LatestValue<OperatorCommand>* commands,
             LatestValue<RemoteSettings>* settings);
  void Stop();
  // Cancels running and later calls, except EmergencyStop. Thread-safe. Stop calls it.
  void EndCalls();
  [[nodiscard]] LinkStats stats() const;  // thread-safe
  // The slave does not permit this identity to operate, so that a retry is useless. Thread-safe.
  [[nodiscard]] bool denied() const;
  // Requests the slave's emergency stop. Returns whether it stopped. Thread-safe. The deadline is 1
  // s, or longer on a slow link.
  bool EmergencyStop(const std::string& reason);
  void GiveUpStop();  // cancels a running EmergencyStop
  // Returns the number of the newest emergency stop that the slave reported. Thread-safe.
  [[nodiscard]] std::uint64_t known_stops() const;
  // Resets the emergency stop number `stops`: that of `known_stops` when the operator decided, so
  // that no later stop is cleared. Returns the reason if it is not reset, else an empty string.
  // Thread-safe.
  std::string Reset(std::uint64_t stops);
  // Cancels a running Reset, because a stop was requested. Thread-safe.
  void CancelReset();
  // Requests new tip, template and baseline. An emergency stop stays active. Returns the reason if
  // the slave rejects it, else an empty string. Thread-safe. The deadline is that of Reset.
  std::string ReinitializeTracking();
  // Change scales and limit, or the model, of the slave while the operator is disengaged. Absent
  // values stay. Return the slave's reason on rejection, else an empty string. Thread-safe. They
  // take at most 1 s, or 15 s for a model.
  struct Mapping {
    std::optional<double> position_scale, force_scale, force_limit;  // [-], [-], [N]
    std::optional<double> young_modulus = {};                        // of the object [Pa]
  };
  std::string SetMapping(const Mapping& mapping);
  std::string SetModel(const std::string& kind);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
