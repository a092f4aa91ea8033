#include "tests/joined/schedule.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <variant>

#include "master/link/operate_session.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

constexpr double kLength = 0.8;             // of a schedule [s]
constexpr double kTimeWithoutFaults = 0.6;  // after it, without faults [s]
constexpr double kEventEvery = 0.08;        // mean [s]
constexpr double kSamplePeriod = 1.0 / 60;
constexpr double kInvalidForce = 1e10;  // the wire allows it, the loop does not [N]

// Time from the last state that the loop used to zero force [s]: link timeout 30 ms, hold 10 ms,
// fade 40 ms, the slew limit's 3.3 N / (0.2 N/ms), and two ticks.
constexpr double kForceEndsWithin = 0.030 + 0.010 + 0.040 + 0.0165 + 0.002;
constexpr double kWatchPeriod = 0.002;  // [s]

double SecondsOf(Clock::duration d) {
  return std::chrono::duration<double>(d).count();
}

}  // namespace

// The operator's stream at the slave: the newest state, with the events of those that it replaced.
class Schedule::Reader final : public StateReader {
 public:
  void Offer(const SlaveState& state) override { box.Put(state); }
  void Close() override {}

  StateMailbox box;
};

Schedule::Schedule(std::uint32_t seed)
    : dice_(seed),
      reader_(std::make_shared<Reader>()),
      loop_({}, {&states_, &commands_, &records_, &settings_, nullptr, nullptr}) {
  slave_minus_master_ = Seconds(dice_.Between(-1000, 1000));
  slave_.Sense();
  const OperatorLease::Answer answer = lease_.RequestTicket("peer", "operator", [](const auto&) {});
  ticket_ = std::get<OperatorLease::Ticket>(answer);
  publisher_.ServeFirst(reader_);
  settings_.Put({1, {}, 3.3, kUsualDeadAfter});
  exchange_.emplace(OperateExchange::Surroundings{
      states_, commands_, trips_, states_received_, states_by_datagram_, [] {},
      [this](const SlaveState& state, const StateRecord&) { OnState(state); },
      [](const std::string&) {}});
  const double delay = dice_.Chance(0.3) ? 0 : dice_.Between(0, 0.040);
  to_slave_.quality = {delay, dice_.Between(0, 0.020), dice_.Between(0, 0.5), dice_.Between(0, 0.3),
                       dice_.Chance(0.6)};
  to_master_.quality = to_slave_.quality;
  state_period_ = dice_.Chance(0.5) ? 0.002 : 0.005;
  depth_ = dice_.Between(0.5e-3, 5e-3);
  frequency_ = dice_.Between(0.5, 3);
}

std::string Schedule::Run() {
  const Time end = begin_ + Seconds(kLength);
  while (now_ < end && violation_.empty()) {
    if (dice_.Chance(SecondsOf(kHapticPeriod) / kEventEvery)) Happen();
    Step();
  }
  // All requests reach the other end once the link works again.
  to_slave_.quality.loss = to_master_.quality.loss = 0;
  is_engaged_ = false;
  invalid_states_until_ = fault_until_ = {};
  for (const Time quiet = end + Seconds(kTimeWithoutFaults); now_ < quiet && violation_.empty();)
    Step();
  Expect(!loop_.stops().is_wanted(), "a requested stop is confirmed");
  Expect(stops_arrived_ == loop_.stops().asked(), "a requested stop reaches the slave");
  Expect(loop_.record().chain.sent.isZero(0), "a disengaged operator gets no force");
  if (slave_.view().phase == Phase::kEstop && violation_.empty()) {
    slave_.Reset(known_stops_);
    Expect(slave_.view().phase != Phase::kEstop, "a reset of the stop that is shown clears it");
  }
  return violation_;
}

void Schedule::Expect(bool holds, const std::string& invariant) {
  if (holds || !violation_.empty()) return;
  std::ostringstream text;
  text << "at " << 1e3 * SecondsOf(now_ - begin_) << " ms violated: " << invariant;
  violation_ = text.str();
}

void Schedule::CallSlave(std::function<void()> call) {
  const Time sent = now_ + Seconds(to_slave_.quality.delay + dice_.Between(0, 0.02));
  const Time together = to_slave_.cut_until() + Seconds(dice_.Between(0, 0.002));
  calls_.emplace(std::max(sent, together), std::move(call));
}

void Schedule::Happen() {
  switch (dice_.Whole(0, 9)) {
    case 0:
      PressStop();
      break;
    case 1:  // by a call of Stop, which is independent of the stream
      PressStop();
      CallSlave([this, asked = loop_.stops().asked()] {
        slave_.EmergencyStop("call");
        NoteStop(asked);
        calls_.emplace(
            now_ + Seconds(to_master_.quality.delay),
            [this, asked, number = slave_.stops()] { loop_.stops().Act(asked, number); });
      });
      break;
    case 2:
    case 3:
      CallSlave([this, press = ++presses_, stops = known_stops_] {
        if (slave_.view().phase != Phase::kEstop) return;
        if (stops == slave_.stops() && dice_.Chance(0.5)) slave_.StopDuringNextReset();
        try {
          slave_.Reset(stops);
          if (open_press_ < press) open_press_ = 0;
        } catch (const std::logic_error&) {  // another stop arrived
        }
      });
      break;
    case 4:
      CallSlave([this] {
        try {
          slave_.SetParameters(
              {.position_scale = dice_.Between(0.5, 2), .force_scale = dice_.Between(0.5, 2)},
              nullptr);
        } catch (const std::logic_error&) {  // an operator follows
          return;
        }
        const SlaveDescription description = slave_.Describe();
        calls_.emplace(now_ + Seconds(dice_.Between(0, 0.1)), [this, description] {
          settings_.Put({description.settings_revision,
                         description.scene.operator_options.transform, 3.3, kUsualDeadAfter});
        });
      });
      break;
    case 5:
      fault_until_ = now_ + Seconds(dice_.Between(0.001, 0.030));
      break;
    case 6:
      invalid_states_until_ = now_ + Seconds(dice_.Between(0.02, 0.4));
      break;
    case 7:
      to_slave_.Cut(now_ + Seconds(dice_.Between(0.02, 0.3)));
      break;
    case 8:
      to_master_.Cut(now_ + Seconds(dice_.Between(0.02, 0.3)));
      break;
    default:
      is_engaged_ = !is_engaged_;
  }
  // Most of the time the operator holds on.
  if (dice_.Chance(0.5)) is_engaged_ = true;
}

void Schedule::Step() {
  now_ += kHapticPeriod;
  RunSlave();
  RunMaster();
}

void Schedule::OnState(const SlaveState& state) {
  known_stops_ = state.stops;
}

void Schedule::PressStop() {
  loop_.stops().Request();
  presses_of_stops_[loop_.stops().asked()] = ++presses_;
}

void Schedule::NoteStop(std::uint32_t asked) {
  stops_arrived_ = std::max(stops_arrived_, asked);
  open_press_ = std::max(open_press_, presses_of_stops_.at(asked));
}

void Schedule::TakeCommand(const CommandPacket& packet) {
  const std::uint64_t taken = slave_.counts().taken, newest = slave_.view().command_sequence;
  if (packet.message.stop()) NoteStop(packet.stops_asked);
  lease_.Command(ticket_, packet.message);
  const bool acted = slave_.counts().taken != taken;
  Expect(!acted || packet.message.sequence() > newest, "a command acts once");
  if (acted && packet.used_sequence > used_sequence_) {
    used_sequence_ = packet.used_sequence;
    used_newer_at_ = SlaveNow();
  }
}

void Schedule::RunSlave() {
  for (; !calls_.empty() && calls_.begin()->first <= now_;) {
    const auto call = calls_.extract(calls_.begin());
    call.mapped()();
    CheckSlave();
  }
  to_slave_.Deliver(now_, [&](const CommandPacket& packet, bool) {
    TakeCommand(packet);
    CheckSlave();
  });
  if (now_ >= next_sample_) {
    next_sample_ = now_ + Seconds(kSamplePeriod);
    const bool is_invalid = now_ < invalid_states_until_;
    slave_.Sense(is_invalid ? std::optional(kInvalidForce) : std::nullopt);
  }
  slave_.Watch();
  CheckSlave();
  const double unused = SecondsBetween(used_newer_at_, SlaveNow());
  Expect(slave_.view().phase != Phase::kFollowing || used_sequence_ == 0 ||
             unused <= kAcknowledgementTimeout + kWatchPeriod,
         "the tool holds where the loop uses no newer state");
  if (now_ < next_state_) return;
  next_state_ = now_ + Seconds(state_period_);
  publisher_.Publish(SlaveNow());
  const auto state = reader_->box.TakeNewest();
  StatePacket packet{.message = {}, .stops_arrived = stops_arrived_};
  ToProto(*state, &packet.message);
  sent_states_[state->sequence] = {state->phase, stops_arrived_, state->settings_revision};
  to_master_.Send(now_, packet, &dice_);
}

DeviceReading Schedule::Read() const {
  const double phase = 2 * std::numbers::pi * frequency_ * SecondsOf(now_ - begin_);
  DeviceReading reading;
  reading.p_M = {0, -depth_ * (1 - std::cos(phase)) / 2, 0};
  reading.v_M = {0, -std::numbers::pi * frequency_ * depth_ * std::sin(phase), 0};
  reading.engaged = is_engaged_;
  if (now_ < fault_until_) reading.status.fault = DeviceFault::kDriver;
  return reading;
}

void Schedule::RunMaster() {
  to_master_.Deliver(now_, [&](const StatePacket& packet, bool is_datagram) {
    if (is_datagram) {
      exchange_->TakeDatagram(std::make_shared<v1::SlaveState>(packet.message), now_);
    } else {
      exchange_->TakeFromStream(std::make_shared<v1::SlaveState>(packet.message), now_);
    }
  });
  const DeviceReading reading = Read();
  const Eigen::Vector3d force = loop_.Tick(reading, now_);
  for (TickRecord drained; records_.Pop(&drained);) {
  }
  CheckMaster(reading, force);
  const auto since = now_ - begin_;
  if (since % OperateSession::kCommandPeriod != Clock::duration::zero()) return;
  const auto command = exchange_->NextCommand(now_);
  if (!command) return;
  CommandPacket packet;
  ToProto(*command, &packet.message);
  packet.used_sequence = loop_.record().state_sequence;
  if (command->stop) packet.stops_asked = loop_.stops().asked();
  to_slave_.Send(now_, packet, &dice_);
}

void Schedule::CheckSlave() {
  const bool is_stopped = slave_.view().phase == Phase::kEstop;
  Expect(is_stopped || !slave_.has_open_stop(), "an emergency stop lasts until its reset");
  Expect(is_stopped || open_press_ == 0, "a stop that is pressed after a reset outlives it");
  Expect(is_stopped == slave_.is_stop_recorded(), "tool and record of the stop agree");
}

void Schedule::CheckMaster(const DeviceReading& reading, const Eigen::Vector3d& force) {
  const TickRecord& record = loop_.record();
  Expect(force.allFinite() && force.norm() <= 3.3 * (1 + 1e-12), "the force is within its limit");
  if (record.state_sequence > loop_sequence_) {
    loop_sequence_ = record.state_sequence;
    loop_newer_at_ = now_;
  }
  const bool is_old = SecondsBetween(loop_newer_at_, now_) > kForceEndsWithin;
  Expect(!is_old || force.isZero(0), "the force ends where the loop has no newer state");
  if (record.state_sequence != 0) {
    const Sent& sent = sent_states_.at(record.state_sequence);
    const bool confirms =
        sent.phase == Phase::kEstop && sent.stops_arrived == loop_.stops().asked();
    Expect(!confirms || !loop_.stops().is_wanted(), "a state that shows the stop confirms it");
    const bool renders =
        record.state == OperatorState::kFollowing && !record.chain.reasons.Has(Reason::kSettings);
    const JoinedSlave::Scales used{record.position_scale, record.force_scale};
    Expect(!renders || used == slave_.ScalesOf(sent.revision), "settings change as a whole");
  }
  if (reading.status.fault != DeviceFault::kNone) faulty_epoch_ = record.epoch;
  if (!faulty_epoch_) return;
  if (record.state == OperatorState::kFollowing && record.epoch > *faulty_epoch_) {
    faulty_epoch_.reset();
  } else {
    Expect(force.isZero(0), "after a fault of the device no force before a new engagement");
  }
}

}  // namespace palpate
