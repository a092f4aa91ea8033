// Haptic loop, exchange of messages, publisher, lease and operator port in one process on one
// clock, joined by lines that lose, delay, repeat and reorder messages. One seed is one schedule.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "master/haptics/haptic_loop.h"
#include "master/link/operate_exchange.h"
#include "slave/service/operator_lease.h"
#include "slave/service/publisher.h"
#include "slave/service/state_mailbox.h"
#include "tests/joined/joined_slave.h"
#include "tests/support/dice.h"

namespace palpate {

// The messages on the link, with the data that the test records about them.
struct CommandPacket {
  v1::OperatorCommand message;
  // Stops requested by the operator, if this command carries the stop.
  std::uint32_t stops_asked = 0;
  std::uint64_t used_sequence = 0;  // of the state that the loop used in this tick
};
struct StatePacket {
  v1::SlaveState message;
  std::uint32_t stops_arrived = 0;  // number of stops that arrived at the slave with commands
};

struct LineQuality {
  double delay = 0, jitter = 0;     // [s], the jitter uniform
  double loss = 0, repetition = 0;  // of datagrams [-]
  bool has_datagrams = false;
};

// One direction of a link: the ordered stream and the datagrams.
template <class Packet>
class DelayLine {
 public:
  LineQuality quality;

  // Cuts the link: nothing arrives until `end`; the stream then delivers everything at once.
  void Cut(Time end) { cut_until_ = std::max(cut_until_, end); }
  void Send(Time now, const Packet& packet, Dice* dice) {
    const auto arrival = [&] {
      return now + Seconds(quality.delay + quality.jitter * dice->Share());
    };
    last_arrival_ = std::max({last_arrival_, arrival(), cut_until_});
    stream_.emplace(last_arrival_, packet);
    if (!quality.has_datagrams || now < cut_until_) return;
    if (!dice->Chance(quality.loss)) datagrams_.emplace(arrival(), packet);
    if (dice->Chance(quality.repetition)) datagrams_.emplace(arrival(), packet);
  }
  // When all that waits in the line arrives.
  [[nodiscard]] Time cut_until() const { return cut_until_; }
  template <class Take>
  void Deliver(Time now, const Take& take) {
    if (now < cut_until_) return;
    for (; !stream_.empty() && stream_.begin()->first <= now; stream_.erase(stream_.begin())) {
      take(stream_.begin()->second, false);
    }
    for (; !datagrams_.empty() && datagrams_.begin()->first <= now;
         datagrams_.erase(datagrams_.begin())) {
      take(datagrams_.begin()->second, true);
    }
  }

 private:
  std::multimap<Time, Packet> stream_, datagrams_;  // by arrival time
  Time last_arrival_{}, cut_until_{};
};

class Schedule {
 public:
  explicit Schedule(std::uint32_t seed);

  // Runs it. Returns the first violated invariant with its time, or an empty string.
  std::string Run();

 private:
  [[nodiscard]] Time SlaveNow() const { return now_ + slave_minus_master_; }
  void Happen();
  void Step();
  void RunSlave();
  void RunMaster();
  void TakeCommand(const CommandPacket& packet);
  // Like SlaveLink: requests the number of the newest stop when a state reports one.
  void OnState(const SlaveState& state);
  // The operator presses the stop.
  void PressStop();
  // Notes that the request for stop number `asked` has arrived at the slave.
  void NoteStop(std::uint32_t asked);
  [[nodiscard]] DeviceReading Read() const;
  // Calls the slave after the link's delay. Calls that a cut link delayed arrive together, in any
  // order.
  void CallSlave(std::function<void()> call);
  void Expect(bool holds, const std::string& invariant);
  void CheckSlave();
  void CheckMaster(const DeviceReading& reading, const Eigen::Vector3d& force);

  Dice dice_;
  Time now_{std::chrono::hours(1)};
  const Time begin_ = now_;
  Clock::duration slave_minus_master_{};
  std::string violation_;

  // The slave's side.
  JoinedSlave slave_{[this] { return SlaveNow(); }};
  Publisher publisher_{slave_};
  OperatorLease lease_{
      slave_, OperatorLease::kSilence, [](const std::function<void()>& task) { task(); }, {}};
  OperatorLease::Ticket ticket_ = 0;
  class Reader;
  std::shared_ptr<Reader> reader_;
  // By arrival time of the call or of its answer.
  std::multimap<Time, std::function<void()>> calls_;
  Time invalid_states_until_{};  // states that the loop rejects
  Time next_sample_{}, next_state_{};
  double state_period_ = 0.005;  // [s]

  // The master's side.
  LatestValue<ReceivedState> states_;
  LatestValue<OperatorCommand> commands_;
  LatestValue<RemoteSettings> settings_;
  SpscRing<TickRecord> records_{64};
  RoundTrips trips_;
  std::atomic<std::uint64_t> states_received_{0}, states_by_datagram_{0};
  std::uint64_t known_stops_ = 0;  // number of stops that the slave reported
  HapticLoop loop_;
  std::optional<OperateExchange> exchange_;
  bool is_engaged_ = false;
  Time fault_until_{};
  double depth_ = 2e-3, frequency_ = 1;  // of the device's motion [m], [Hz]

  DelayLine<CommandPacket> to_slave_;
  DelayLine<StatePacket> to_master_;

  // Data of a sent state that the invariants need.
  struct Sent {
    Phase phase = Phase::kReady;
    std::uint32_t stops_arrived = 0, revision = 0;
  };
  std::map<std::uint64_t, Sent> sent_states_;  // by sequence
  std::uint32_t stops_arrived_ = 0;
  // Order in which stops and resets were pressed. A reset ends only stops that were pressed before.
  std::uint32_t presses_ = 0,
                open_press_ = 0;  // open_press_: newest stop that is not ended; 0: none
  std::map<std::uint32_t, std::uint32_t> presses_of_stops_;  // by their number
  // State that the loop used last, according to accepted commands.
  std::uint64_t used_sequence_ = 0;
  Time used_newer_at_{};             // slave's clock
  std::uint64_t loop_sequence_ = 0;  // of the state that the loop used last
  Time loop_newer_at_{};             // master's clock
  std::optional<std::uint32_t> faulty_epoch_;
};

}  // namespace palpate
