#include "master/haptics/haptic_loop.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>

#include "master/haptics/renderer.h"
#include "master/haptics/tick_drive.h"
#include "master/haptics/torque.h"
#include "shared/state/slave_state.h"

namespace palpate {
namespace {

constexpr double kMaxValidForce = 1e9;     // larger forces are invalid [N]
constexpr double kMaxValidPosition = 1e4;  // larger positions are invalid [m]

// Returns whether all components are finite and within the limit.
bool IsWithin(const Eigen::Vector3d& v, double limit) {
  return v.allFinite() && v.cwiseAbs().maxCoeff() <= limit;
}

bool IsSane(const FingerState& finger) {
  return IsWithin(finger.p_S_contact.cast<double>(), kMaxValidPosition) &&
         (!finger.force || IsWithin(finger.force->cast<double>(), kMaxValidForce));
}

// Returns whether positions, forces and number of fingertips of a received state can be used at
// all.
bool IsSane(const SlaveState& state) {
  if (state.finger_count < 0 || state.finger_count > kMaxFingers) return false;
  const auto fingers = std::span(state.fingers).first(static_cast<std::size_t>(state.finger_count));
  return std::ranges::all_of(fingers, [](const FingerState& finger) { return IsSane(finger); }) &&
         IsWithin(state.p_S_tip, kMaxValidPosition) && IsWithin(state.offset, kMaxValidPosition) &&
         (!state.force || IsWithin(*state.force, kMaxValidForce)) &&
         (!state.true_force || IsWithin(*state.true_force, kMaxValidForce)) &&
         (!state.local_model.known() || IsSane(state.local_model));
}

constexpr double kFadeIn = 0.050;  // [s]
// The force is zero after `dead_after` and these two times, counted from the last state: 80 ms by
// default.
constexpr double kHoldForce = 0.010;  // time in HOLD before the fade [s]
constexpr double kFadeOut = 0.040;    // [s]
constexpr double kFadeOfSilence =
    0.030;  // after a fault of sensor or manipulator that the slave has waited for [s]
constexpr double kFuture = 0.050;         // accepted lead of a timestamp [s]
constexpr double kOffsetRounding = 1e-6;  // [m]
constexpr double kTicksPerSecond = 1000;

// Returns the sample time on the master's clock.
Time SensedAt(const ReceivedState& received) {
  return received.state.sensed_at - Seconds(received.clock_offset);
}

// `stiffest` at the device, converted to the tool [N/m].
double AtTool(double stiffest, const TeleopTransform& transform) {
  return stiffest / (transform.position_scale * transform.force_scale);
}

// Returns the surface that the tool at `p_S` meets, frame M.
DeviceGuide SurfaceAt(const Eigen::Vector3d& p_S, const Renderer& renderer,
                      const TeleopTransform& transform, double now) {
  DeviceGuide guide;
  const PatchRender& patch = renderer.patch();
  const Eigen::Matrix3d R_MS = transform.R_SM.transpose();
  if (patch.known() && patch.newest().serves()) {
    guide.known = true;
    guide.inward_M = R_MS * -patch.newest().normal();
    guide.gap_M = -patch.newest().depth() / transform.position_scale;
  } else if (renderer.contact().known()) {
    const LocalModel model = renderer.contact().At(now);
    guide.known = true;
    guide.inward_M = R_MS * -model.normal;
    guide.gap_M = -model.Penetration(p_S) / transform.position_scale;
  }
  return guide;
}

double PositiveOrThrow(double value, const char* name) {
  if (value > 0 && std::isfinite(value)) return value;
  throw std::invalid_argument(std::string(name) + " = " + std::to_string(value) +
                              ": expected > 0 and finite");
}

}  // namespace

HapticLoop::HapticLoop(const Options& options, const Slots& slots)
    : options_(options),
      slots_(slots),
      renderer_(options.render),
      motion_(options.motion, options.stiffest),
      output_(options.slew_limit * kTicksPerSecond),
      transform_(options.transform),
      settings_{options.settings_revision, options.transform, options.force_limit,
                options.dead_after, options.max_age},
      used_revision_(options.settings_revision) {
  PositiveOrThrow(options.force_limit, "force_limit");
  PositiveOrThrow(options.slew_limit, "slew_limit");
  PositiveOrThrow(options.max_age, "max_age");
  PositiveOrThrow(options.transform.position_scale, "position_scale");
  PositiveOrThrow(options.transform.force_scale, "force_scale");
  renderer_.set_stiffest(AtTool(motion_.contact_stiffness(), transform_));
  passivity_.set_max_damping(options.max_damping);
  machine_.set_dead_after(std::clamp(options.dead_after, kMinDeadAfter, kMaxDeadAfter));
}

// Real-time: no allocation, lock, log, exception or network from here down.
void HapticLoop::Run(Device& device, Clock::duration length, const std::stop_token& stop) noexcept {
  std::atomic<bool> lets_go{false};
  TickDrive drive(device, [&](Time now) {
    const Time begin = Clock::now();
    DeviceReading reading = device.Read(now);
    reading.engaged = reading.engaged && !lets_go;
    const Eigen::Vector3d force = Tick(reading, now);
    device.WriteWrench(force, motion_.axes().TorqueToDevice(record_.torque));
    device.Guide(motion_.guide());
    if (lets_go) return sent_ != Eigen::Vector3d::Zero();
    stats_.compute_us.Add(SecondsBetween(begin, Clock::now()) * 1e6);
    return !device.finished();
  });
  drive.Run(length, stop, &stats_.periodic);
  lets_go = true;
  PeriodicStats fade;  // not part of the run
  drive.Run(Seconds(2 * kFadeOut), {}, &fade);
  drive.Stop();
  device.DropForce();
  Release(Clock::now());
}

Eigen::Vector3d HapticLoop::Tick(const DeviceReading& raw, Time now) noexcept {
  const double dt = clock_.Tick(now);
  record_ = TickRecord();
  record_.at = now;
  record_.device = raw.status;
  TakeRequests();
  TakeState(now);
  TakeSettings();
  TakePatch(clock_.ToSeconds(now));
  if (newest_) {
    record_.state_sequence = newest_->state.sequence;
    record_.sensed_at = newest_->state.sensed_at;
    record_.sent_at = newest_->state.sent_at;
    RecordFingers(newest_->state, &record_);
  }
  DeviceReading reading = Checked(motion_.ToMaster(raw));
  record_.clutched = record_.clutched || motion_.IsClutched(reading);
  reading.engaged = reading.engaged && !record_.clutched;
  passivity_.Observe(reading.p_M, sent_, dt);
  StepMachine(now, reading.engaged);
  // The device dropped its force, and a fade would start from a force that it no longer has.
  if (record_.chain.reasons.Has(Reason::kBadDevice)) output_.Drop();
  const OperatorState state = machine_.state();
  const bool follows = state == OperatorState::kFollowing || state == OperatorState::kHold;
  const DeviceReading command = motion_.Command(
      reading, transform_, {machine_.epoch(), machine_.commands_engaged(), follows, dt});
  RunChain(reading, command, clock_.ToSeconds(now), dt);
  DeviceGuide guide;
  if (state == OperatorState::kFollowing) {
    guide = SurfaceAt(record_.p_S, renderer_, transform_, clock_.ToSeconds(now));
  }
  if (newest_) guide.round_trip = newest_->round_trip;
  motion_.SetSurface(guide);
  PutCommand(command, now);
  slots_.records->Push(record_);
  return motion_.axes().ToDevice(sent_);
}

// The rendering mode changes only while no force is rendered.
void HapticLoop::TakeRequests() noexcept {
  if (slots_.requests == nullptr) return;
  const OperatorRequests& requests = *slots_.requests;
  options_.force_limit = std::min(options_.force_limit, requests.force_limit.load());
  record_.marks = requests.marks;
  record_.clutched = requests.clutched;
  if (!machine_.commands_engaged()) renderer_.set_mode(requests.render);
  tare_.Request(requests.tares.load());
}

void HapticLoop::TakeState(Time now) noexcept {
  const ReceivedState* received = slots_.states->Take();
  if (received == nullptr) return;
  if (!IsSane(received->state) || !IsWithin({received->clock_offset, 0, 0}, 1e9)) {
    record_.chain.reasons.Add(Reason::kBadState);  // and the watchdog keeps running
    return;
  }
  newest_ = *received;
  if (received->observed) return;
  if (received->ended) base_trip_ = {};
  if (received->round_trip > 0) {
    base_trip_.Learn(received->round_trip, std::max(0.0, SecondsBetween(learned_at_, now)));
    learned_at_ = now;
  }
  tare_.Take(&newest_->state, machine_.commands_engaged(),
             options_.force_limit / transform_.force_scale, clock_.ToSeconds(now));
  const SlaveState& state = newest_->state;
  const auto offset = Seconds(received->clock_offset);
  renderer_.Take(state, clock_.ToSeconds(state.sensed_at - offset),
                 clock_.ToSeconds(received->received_at), clock_.ToSeconds(now));
  renderer_.set_ahead(received->round_trip / 2);
  record_.round_trip = received->round_trip;
  CompareWithSlave(state);
  if (state.true_force) {
    record_.has_truth = true;
    record_.truth_at = state.sent_at - offset;
    if (state.echo) record_.truth_commanded_at = *state.echo;
    record_.truth = *state.true_force;
  }
}

// A patch of other settings waits, or is outdated.
void HapticLoop::TakePatch(double now) noexcept {
  const ReceivedPatch* received = slots_.patches == nullptr ? nullptr : slots_.patches->Take();
  if (received != nullptr) patch_ = received;
  if (patch_ == nullptr || !newest_ || settings_wait_) return;
  const std::uint32_t revision = patch_->patch.settings_revision;
  if (revision != settings_.revision && revision != 0) return;
  const auto offset = Seconds(newest_->clock_offset);
  renderer_.TakePatch(patch_->patch, patch_->law, clock_.ToSeconds(patch_->law.sensed_at - offset),
                      now);
  patch_ = nullptr;
}

// Compares the model with the estimate for a command of one round trip ago.
void HapticLoop::CompareWithSlave(const SlaveState& state) noexcept {
  const bool follows = machine_.state() == OperatorState::kFollowing && state.echo &&
                       state.epoch == machine_.epoch() && state.phase == Phase::kFollowing;
  if (!follows || state.sensed_at == judged_at_) return;
  judged_at_ = state.sensed_at;
  const double since_sensed = SecondsBetween(state.sensed_at, state.sent_at);
  renderer_.CompareWithSlave(clock_.ToSeconds(*state.echo) + state.echo_delay - since_sensed,
                             state);
}

// A lower limit acts at once. Scales wait, because they would move the tool.
void HapticLoop::TakeSettings() noexcept {
  const RemoteSettings* read = slots_.settings == nullptr ? nullptr : slots_.settings->Take();
  if (read != nullptr) {
    settings_ = *read;
    settings_wait_ = true;
    options_.force_limit = std::min(options_.force_limit, read->force_limit);
    machine_.set_dead_after(std::clamp(read->dead_after, kMinDeadAfter, machine_.dead_after()));
  }
  if (!settings_wait_ || machine_.commands_engaged()) return;
  settings_wait_ = false;
  transform_ = settings_.transform;
  used_revision_ = settings_.revision;
  offset_epoch_ = 0;  // the slave may have continued this epoch with its own offset
  renderer_.set_stiffest(AtTool(motion_.contact_stiffness(), transform_));
  renderer_.ForgetPatch();
  tare_.Forget();
}

bool HapticLoop::IsNewestStateUsable(Time now) noexcept {
  const SlaveState& state = newest_->state;
  const double age = SecondsBetween(SensedAt(*newest_), now);
  // Uses the smallest round trip, because a slave that delays its echoes must not make old states
  // acceptable.
  const double delay = std::min({base_trip_.OrZero(), newest_->round_trip, options_.max_trip});
  const double oldest = settings_.max_age + delay;
  Reasons flags;
  if (!(age <= oldest && age >= -kFuture)) flags.Add(Reason::kAged);
  if (settings_wait_ || state.settings_revision != settings_.revision) flags.Add(Reason::kSettings);
  if (!KeepsOffset()) flags.Add(Reason::kOffsetJump);
  if (newest_->ended) flags.Add(Reason::kEnded);
  record_.chain.reasons.Add(flags);
  return flags.empty();
}

// The first offset of an epoch is valid for the epoch while the operator is engaged. A slave that
// was restarted under an emergency stop has another offset for an epoch that has ended.
bool HapticLoop::KeepsOffset() noexcept {
  const SlaveState& state = newest_->state;
  if (state.epoch != machine_.epoch()) return true;
  if (offset_epoch_ != state.epoch || !machine_.commands_engaged()) {
    offset_epoch_ = state.epoch;
    transform_.offset = state.offset;
  }
  return (state.offset - transform_.offset).norm() <= kOffsetRounding;
}

DeviceReading HapticLoop::Checked(const DeviceReading& reading) noexcept {
  const bool good = reading.status.fault == DeviceFault::kNone &&
                    IsWithin(reading.p_M, kMaxValidPosition) &&
                    IsWithin(reading.v_M, kMaxValidPosition);
  if (good) return last_reading_ = reading;
  record_.chain.reasons.Add(Reason::kBadDevice);
  DeviceReading kept;
  kept.p_M = last_reading_.p_M;
  kept.q_M = last_reading_.q_M;
  return kept;
}

void HapticLoop::StepMachine(Time now, bool engaged) noexcept {
  OperatorMachine::Input in;
  in.now = clock_.ToSeconds(now);
  in.engaged = engaged;
  in.settings_wait = settings_wait_;
  if (newest_) {
    in.state_age = std::max(0.0, SecondsBetween(newest_->received_at, now));
    in.round_trip = newest_->round_trip;
    in.observed = newest_->observed;
    in.trusted = !in.observed && IsNewestStateUsable(now);
    in.force_known = IsForceKnown(newest_->state);
    in.slave_epoch = newest_->state.epoch;
    in.slave_phase = newest_->state.phase;
    record_.state_age = in.state_age;
    record_.sensed_age = SecondsBetween(SensedAt(*newest_), now);
    if (newest_->ended) in.state_age = 1e9;
  }
  if (newest_) stops_.Take(newest_->state, newest_->observed);
  in.stop = stops_.is_pending();
  const OperatorState before = machine_.state();
  const OperatorState after = machine_.Step(in);
  if (after == OperatorState::kFollowing && before == OperatorState::kAligning)
    passivity_.RenewCredit();
  if (after != before) OnStateChange(after);
  if (after == OperatorState::kHold) FadeOutOfHold(in.now);

  Reasons& reasons = record_.chain.reasons;
  if (!machine_.commands_engaged()) reasons.Add(Reason::kNotFollowing);
  if (in.state_age > machine_.dead_after()) reasons.Add(Reason::kStale);
  if (newest_ && !in.force_known) reasons.Add(Reason::kUnknown);
  if (newest_ && newest_->state.check == FailedCheck::kArmFault) reasons.Add(Reason::kArmFault);
  if (machine_.commands_engaged() && in.slave_epoch != machine_.epoch()) {
    reasons.Add(Reason::kOtherEpoch);
  }
}

void HapticLoop::OnStateChange(OperatorState to) noexcept {
  hold_is_fading_ = false;
  if (to == OperatorState::kFollowing) {
    passivity_.CreditStored();
    output_.Go(OutputBlend::Target::kRendered, kFadeIn);
  } else if (to == OperatorState::kHold) {
    output_.Go(OutputBlend::Target::kFrozen, 0);
  } else {
    output_.Go(OutputBlend::Target::kZero, kFadeOut);
  }
  if (to == OperatorState::kAligning) renderer_.ForgetForces();
}

// Hold the force in a short gap of the link, which may end soon. A stale sensor has been silent for
// 60 ms or more, and a faulty manipulator for 40 ms. Including the network delay the force is zero
// within 100 ms.
void HapticLoop::FadeOutOfHold(double now) noexcept {
  const SlaveState& state = newest_->state;
  const bool is_silent =
      state.validity == Validity::kStale || state.check == FailedCheck::kArmFault;
  const bool may_return = !newest_->ended && !is_silent;
  if (hold_is_fading_ || (may_return && now - machine_.since() < kHoldForce)) return;
  hold_is_fading_ = true;
  output_.Go(OutputBlend::Target::kZero, is_silent ? kFadeOfSilence : kFadeOut);
}

void HapticLoop::RunChain(const DeviceReading& reading, const DeviceReading& command, double now,
                          double dt) noexcept {
  const OperatorState state = machine_.state();
  const bool renders = state == OperatorState::kFollowing || state == OperatorState::kHold;
  ForceChain& chain = record_.chain;
  record_.state = state;
  record_.epoch = machine_.epoch();
  record_.p_M = reading.p_M;
  record_.p_S = transform_.ToSlave(command.p_M);
  record_.position_scale = transform_.position_scale;
  record_.force_scale = transform_.force_scale;
  record_.force_limit = options_.force_limit;
  if (newest_) record_.p_S_tip = newest_->state.p_S_tip;
  record_.model_stiffness = renderer_.reported_stiffness();
  if (!renders) record_.p_S = newest_ ? newest_->state.p_S_tip : Eigen::Vector3d::Zero();
  record_.render = renderer_.mode();
  record_.tare_state = tare_.state();
  record_.tare = tare_.bias();
  if (!record_.tare.isZero(0)) chain.reasons.Add(Reason::kTared);
  chain.force_known = newest_ && IsForceKnown(newest_->state);
  if (chain.force_known) chain.estimated = *newest_->state.force;
  if (renders) chain.local = renderer_.Render(record_.p_S, now, &chain.reasons);
  chain.scaled = transform_.ForceToMaster(chain.local);
  if (renders && motion_.is_active()) {
    chain.scaled = motion_.ForceAtDevice(chain.scaled);
    chain.reasons.Add(Reason::kFixture);
  }
  const double slew = options_.slew_limit * kTicksPerSecond;
  chain.passive = passivity_.Apply(chain.scaled, reading.v_M, dt);
  chain.passive = passivity_.LimitToBalance(chain.passive, reading.v_M, slew);
  if (chain.passive != chain.scaled) chain.reasons.Add(Reason::kPassivity);
  chain.limited = LimitForce(chain.passive, options_.force_limit, &chain.reasons);
  // A held or fading force also needs energy: it would drive a device that draws back.
  const Eigen::Vector3d wanted = output_.Wanted(chain.limited, dt);
  const Eigen::Vector3d afforded = passivity_.LimitToBalance(wanted, reading.v_M, slew);
  if (afforded != wanted) chain.reasons.Add(Reason::kPassivity);
  chain.sent = output_.Send(afforded, dt);
  if (output_.is_slewed()) chain.reasons.Add(Reason::kSlewed);
  if (output_.is_blending() && chain.sent != chain.limited) chain.reasons.Add(Reason::kFading);
  sent_ = chain.sent;
  if (options_.renders_torque && renders) {
    record_.torque = TorqueAtDevice(newest_->state, chain, transform_);
  }
  record_.energy = passivity_.energy_in() - passivity_.energy_out();
}

OperatorCommand HapticLoop::NextCommand(Time now) noexcept {
  ++commanded_.sequence;
  OperatorCommand command = commanded_;
  command.sent_at = now;
  command.epoch = machine_.epoch();
  command.settings_revision = used_revision_;
  command.torque = options_.renders_torque;
  return command;
}

// Positions are absolute in the epoch. While the force is unknown, the command keeps the last
// position with a known force.
void HapticLoop::PutCommand(const DeviceReading& wanted, Time now) noexcept {
  const bool holding = machine_.state() == OperatorState::kHold;
  if (!holding) {
    commanded_.p_M = wanted.p_M;
    if (options_.sends_orientation) commanded_.R_M_device = wanted.q_M;
  }
  OperatorCommand command = NextCommand(now);
  if (!holding) command.velocity = wanted.v_M;
  command.engaged = machine_.commands_engaged();
  stops_.Put(&command);
  if (newest_) {
    command.state_sequence = newest_->state.sequence;
    command.echo = newest_->state.sent_at;
  }
  slots_.commands->Put(command);
}

void HapticLoop::Release(Time now) noexcept {
  slots_.commands->Put(NextCommand(now));
}

}  // namespace palpate
