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
#include "master/link/state_record.h"
#include "shared/link/latest_value.h"
#include "shared/state/slave_state.h"

namespace palpate {

class OperatorCalls;

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
  // This link observes: nobody can operate the slave (no manipulator, no scene yet), or it does not
  // want to.
  bool observes = false;
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
    std::chrono::milliseconds max_round_trip{1000};  // accepted at least
    // Called for each received state and each sent command on the link's threads. May be empty.
    std::function<void(const StateRecord&)> on_received = {};
    std::function<void(const OperatorCommand&)> on_sent = {};  // must not keep the reference
    bool details = false;  // request the values of the slave's checks, and the moment
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
  [[nodiscard]] std::chrono::milliseconds max_round_trip() const;
  // Opens the Operate stream and keeps it open, reconnecting with back-off, until Stop. Sends from
  // `commands` 500 times a second and puts received states into `states`. Puts settings into
  // `settings` before each stream and after each change. All three must outlive the link. While the
  // slave refuses the stream, it observes the slave instead, and the states say so.
  // Not `operates`: it requests no lease and observes.
  void Start(LatestValue<ReceivedState>* states, LatestValue<OperatorCommand>* commands,
             LatestValue<RemoteSettings>* settings, bool operates);
  void Stop();
  // Cancels running and later calls, except EmergencyStop. Thread-safe. Stop calls it.
  void EndCalls();
  [[nodiscard]] LinkStats stats() const;    // thread-safe
  [[nodiscard]] StateRecord state() const;  // the newest; thread-safe
  Events TakeEvents();                      // of the slave since the last call; thread-safe
  // The slave does not permit this identity to operate, so that a retry is useless. Thread-safe.
  [[nodiscard]] bool denied() const;
  // What an operator calls beside the stream.
  [[nodiscard]] OperatorCalls& calls();
  // Scales and limit of the slave, see OperatorCalls. Absent values stay.
  struct Mapping {
    std::optional<double> position_scale, force_scale, force_limit;  // [-], [-], [N]
    std::optional<double> young_modulus = {};                        // of the object [Pa]
  };

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
