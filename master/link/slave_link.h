// The master's line to the slave: connects, keeps one Operate stream, measures it, reconnects. The
// haptic loop only ever touches the two latest-value slots.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "master/link/remote_scene.h"
#include "shared/link/latest_value.h"
#include "shared/state/slave_state.h"

namespace palpate {

// A state as it arrived.
struct ReceivedState {
  SlaveState state;
  Time received_at{};       // master's clock
  double clock_offset = 0;  // slave's clock minus master's [s], by the best of recent round trips
  double round_trip = 0;    // of the newest command that came back [s]
  bool ended = false;       // the stream ended after this one
};

// What the master goes by, as it was read from the slave.
struct RemoteSettings {
  std::uint32_t revision = 0;           // 0: of a slave that tells none
  TeleopTransform transform;            // offset zero
  double force_limit = 0;               // at the hand [N], > 0
  double dead_after = kUsualDeadAfter;  // without a state the link is dead [s]
};

struct LinkStats {
  bool connected = false;
  std::uint64_t states = 0, commands = 0, reconnects = 0;
  std::uint64_t refused = 0;  // states that could not be read: a number missing, not finite, absurd
  double rtt_p50_us = 0, rtt_p99_us = 0, rtt_max_us = 0;
  double clock_offset = 0;  // [s]
  // Why it is not connected, who holds the lease, why the last state was refused, or that no
  // datagrams come; empty: nothing.
  std::string trouble;
  bool answers = false;  // while it is not connected: the slave is there, and says why it refuses
  std::uint64_t states_by_datagram = 0;  // of `states`: that came so before they came by the stream
  // By what was known of the slave's clock: of `states`, when they came, since they left, and since
  // they were sensed; of the newest command, when a state left the slave, since it was sent.
  struct Times {
    double p50_us = 0, p99_us = 0, max_us = 0;
  } delay, age, command_age;
};

class SlaveLink {
 public:
  struct Options {
    std::string target;         // HOST:PORT
    double wait = 10;           // how long Connect retries [s]
    bool insecure = false;      // allow targets that are not loopback, in plain text
    std::filesystem::path tls;  // the folder of our certificate; empty: plain text
    std::string operator_name;
    std::chrono::milliseconds longest_round_trip{1000};  // at least reckoned with
    // Told of each state as it came, and of each command as it left, by the link's own threads;
    // must not keep them. Empty: nobody.
    std::function<void(const ReceivedState&)> on_received = {};
    std::function<void(const OperatorCommand&)> on_sent = {};
    // States and commands travel by datagram, too, where slave and network let them: what is lost
    // is not waited for. Empty: where the target is another machine; over loopback nothing is lost,
    // and a tunnel or a proxy for TCP that ends there takes no datagrams.
    std::optional<bool> datagrams = {};
  };
  // Throws std::invalid_argument: target not understood, or not loopback without `insecure`.
  explicit SlaveLink(Options options);
  ~SlaveLink();

  // Retries for `wait`. Throws std::runtime_error: nobody there (what was tried), wrong version.
  // Lines of seconds of round trip have the time they need, of `wait`.
  RemoteScene Connect();
  // That the line turned out to need. After Connect.
  [[nodiscard]] std::chrono::milliseconds longest_round_trip() const;
  // Opens the Operate stream and keeps it open, reconnecting with back-off, until Stop. Commands
  // are taken from `commands` 500 times a second, states put into `states` as they arrive, what the
  // master is to go by into `settings`: before each stream, and when a state tells that it changed.
  // All outlive the link.
  void Start(LatestValue<ReceivedState>* states, LatestValue<OperatorCommand>* commands,
             LatestValue<RemoteSettings>* settings);
  void Stop();
  [[nodiscard]] LinkStats stats() const;  // thread-safe
  // The slave does not let who we are operate, and never did: to ask again is of no use.
  // Thread-safe.
  [[nodiscard]] bool denied() const;
  // The slave's emergency stop, and its end. Thread-safe, deadline 1 s or what the line needs;
  // true: it was done.
  bool EmergencyStop(const std::string& reason);
  void GiveUpStop();  // ends the call that is under way
  // After the last stop that is told: what is still on its way would undo it.
  bool Reset();
  // Tip, template and rest are found anew, a stop stays. Empty: it was asked for, else why not.
  // Thread-safe, deadline as for Reset.
  std::string ReinitializeTracking();
  // Changes what the slave maps and models with, while nobody follows: what is not told stays.
  // Empty: it was done, else why not, in the slave's words. Thread-safe; at most 1 s, 15 s for a
  // model.
  struct Mapping {
    std::optional<double> position_scale, force_scale, force_limit;  // [-], [-], [N]
  };
  std::string SetMapping(const Mapping& mapping);
  std::string SetModel(const std::string& kind);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
