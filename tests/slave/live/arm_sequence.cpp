#include "tests/slave/live/arm_sequence.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "slave/live/operator_port.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kSpeed = 0.05, kReach = 0.2;             // of the arm [m/s], of its workspace [m]
constexpr double kForceGuard = 2, kDepthGuard = 4e-3;     // [N], [m]
constexpr double kBlindAfter = 0.25, kDeadAfter = 0.030;  // [s]
constexpr double kStep = 0.002;                           // of the watchdog [s]
constexpr double kExact = 1e-9;                           // [m]
const Vector3d kOutward(0, 1, 0);

// Rules for every position that is commanded to the arm.
struct Rules {
  bool is_stopped = false, is_faulty = false, operates = false;
  // A guard was reached, and it is not known to have fallen below its limit.
  bool is_guarded = false;
  double unknown_for = 0;  // the force [s]
};

class CheckedArm final : public Manipulator {
 public:
  explicit CheckedArm(const Rules* rules) : rules_(rules) {}

  bool Command(const Vector3d& p_S_target) noexcept override {
    target_ = p_S_target;
    if (!complaint_.empty()) return true;
    if (!p_S_target.allFinite()) complaint_ = "target that is not finite";
    if (rules_->is_stopped) complaint_ = "target under an emergency stop";
    if (rules_->is_faulty) complaint_ = "target with a fault";
    const Vector3d within = p_S_target.cwiseMax(-kReach).cwiseMin(kReach);
    const Vector3d way = within - tip_;
    if (rules_->is_guarded && way.dot(kOutward) < -kExact)
      complaint_ = "target deeper under a guard";
    if (!by_operator) return true;
    if (!rules_->operates) complaint_ = "led by nobody";
    if (rules_->unknown_for > kBlindAfter + kStep) complaint_ = "led in the blind";
    if (way.norm() > kLeapTime * kSpeed + kExact) complaint_ = "target farther than a leap";
    return true;
  }
  void Hold() noexcept override { target_.reset(); }
  [[nodiscard]] Vector3d Tip() const noexcept override { return tip_; }
  [[nodiscard]] bool at_limit() const noexcept override { return false; }
  [[nodiscard]] bool carries_tool() const noexcept override { return true; }
  [[nodiscard]] bool is_faulty() const noexcept override { return rules_->is_faulty; }

  void Step() {
    if (!target_ || rules_->is_faulty) return;
    const Vector3d way = target_->cwiseMax(-kReach).cwiseMin(kReach) - tip_;
    tip_ += std::min(1.0, kSpeed * kStep / std::max(way.norm(), 1e-12)) * way;
  }
  [[nodiscard]] const std::string& complaint() const { return complaint_; }
  [[nodiscard]] std::optional<Vector3d> target() const { return target_; }

  bool by_operator = false;  // the operator commands the arm; otherwise the port retreats

 private:
  const Rules* rules_;
  Vector3d tip_{0, 0, 0};
  std::optional<Vector3d> target_;
  std::string complaint_;
};

class Sequence {
 public:
  explicit Sequence(Choices choices) : choices_(choices), limits_(Limits(&choices_)) {}

  void Run() {
    while (!choices_.over()) {
      Change();
      Demand(arm_.complaint().empty(), arm_.complaint());
    }
  }

 private:
  static ManipulatorOptions Limits(Choices* choices) {
    ManipulatorOptions limits;
    limits.max_speed = kSpeed;
    limits.workspace_min.setConstant(-kReach);
    limits.workspace_max.setConstant(kReach);
    limits.force_guard = kForceGuard;
    limits.depth_guard = kDepthGuard;
    limits.guard_retracts = choices->Coin();
    limits.blind_after = kBlindAfter;
    return limits;
  }
  void Change() {
    switch (choices_.Below(16)) {
      case 0:
        return Operate();
      case 1:
        port_.EmergencyStop();
        rules_.is_stopped = true;
        last_epoch_ = port_.view().epoch;
        is_open_ = false;
        return;
      case 2:
        port_.Reset(port_.stops());
        Demand(port_.view().phase != Phase::kEstop, "a stop that stays");
        rules_.is_stopped = false;
        return;
      case 3:
        return Scale();
      case 4:
        return Register();
      case 5:
        rules_.is_faulty = choices_.Coin();
        return;
      case 6:
      case 7:
        return Estimate();
      case 8:
      case 9:
        return Watch(1 + choices_.Byte());
      case 10:
        return Send(Wild());
      default:
        return Lead();
    }
  }
  void Operate() {
    rules_.operates = choices_.Byte() % 4 != 0;
    if (rules_.operates) {
      port_.BeginOperating();
      largest_epoch_ = last_epoch_ = 0;
      sequence_ = 0;
    } else {
      port_.EndOperating();
    }
    followed_.reset();
  }
  void Scale() {
    constexpr std::array<double, 3> kScales{0.1, 1, 10};
    const bool follows = port_.view().phase == Phase::kFollowing;
    try {
      port_.SetScales(choices_.Among(kScales), std::nullopt);
      Demand(!follows, "a scale that changes under the hand");
    } catch (const std::logic_error&) {
      if (!follows) throw;
    }
  }
  void Register() {
    if (port_.view().phase != Phase::kFollowing) followed_.reset();
    port_.SetRegistration(1e-3 * choices_.Within(1));
  }
  void Estimate() {
    contact_ = {};
    contact_.outward = kOutward;
    if (choices_.Byte() % 4 != 0) contact_.force = choices_.Within(0, 4) * kOutward;
    contact_.depth = choices_.Within(0, 8e-3);
    if (choices_.Coin()) contact_.force_by_now = choices_.Within(0, 4);
    if (choices_.Coin()) contact_.depth_by_now = choices_.Within(0, 8e-3);
    Watch(1);
  }
  void Watch(int steps) {
    for (int i = 0; i < steps; ++i) {
      now_ += Seconds(kStep);
      arm_.Step();
      Know();
      port_.Watch(now_, contact_);
    }
  }
  void Know() {
    const double estimate = contact_.force ? contact_.force->norm() : 0;
    const double force = std::max(estimate, contact_.force_by_now);
    const double depth = std::max(contact_.depth, contact_.depth_by_now);
    // While the guard is active, its limits are reduced by 5 %.
    if (force > kForceGuard || depth > kDepthGuard) {
      rules_.is_guarded = true;
    } else if (contact_.force && force <= 0.95 * kForceGuard && depth <= 0.95 * kDepthGuard) {
      rules_.is_guarded = false;
    }
    rules_.unknown_for = contact_.force ? 0 : rules_.unknown_for + kStep;
  }
  // Moves as a normal operator does, for a while.
  void Lead() {
    const bool engages = choices_.Byte() % 4 == 0;
    const bool is_engaged = choices_.Byte() % 8 != 0;
    const Vector3d speed = 0.5 * kSpeed * choices_.Within(1);
    if (engages) ++largest_epoch_;
    for (int left = choices_.Byte() / 4; left >= 0; --left) {
      hand_ += kStep * speed;
      OperatorCommand command;
      command.p_M = hand_;
      command.velocity = speed;
      command.engaged = is_engaged;
      command.epoch = largest_epoch_;
      Send(command);
      Watch(1);
    }
  }
  OperatorCommand Wild() {
    OperatorCommand command;
    command.p_M = hand_ + choices_.Within(0.5);
    if (choices_.Coin()) command.p_M[1] = choices_.Wild();
    if (choices_.Coin()) command.velocity[0] = choices_.Wild();
    command.engaged = choices_.Byte() % 4 != 0;
    command.epoch = largest_epoch_ + static_cast<std::uint32_t>(choices_.Below(3));
    return command;
  }
  void Send(OperatorCommand command) {
    command.sequence = ++sequence_;
    command.sent_at = now_;
    const double scale = port_.transform().position_scale;
    const Vector3d tip = arm_.Tip();
    arm_.by_operator = true;
    const bool is_taken = port_.Command(command, now_);
    arm_.by_operator = false;
    const OperatorView view = port_.view();
    if (is_taken && !command.engaged && !rules_.is_stopped) is_open_ = true;
    largest_epoch_ = std::max(largest_epoch_, view.epoch);
    if (!(is_taken && view.phase == Phase::kFollowing)) return followed_.reset();
    Demand(command.engaged, "it follows an open clutch");
    Demand(command.p_M.allFinite() && command.velocity.allFinite(), "it follows no numbers");
    Demand(scale * command.velocity.norm() <= kFastest * kSpeed, "it follows a leap");
    Demand(is_open_ || command.epoch > last_epoch_, "a stop that needs no engagement");
    const bool is_new = std::exchange(followed_epoch_, command.epoch) != command.epoch;
    if (rules_.is_guarded) return followed_.reset();
    if (!followed_) Demand(view.epoch == command.epoch, "another engagement than the hand's");
    if (followed_ && followed_->epoch == command.epoch) {
      const Vector3d way = *arm_.target() - followed_target_;
      const Vector3d asked = scale * (command.p_M - followed_->p_M);
      Demand((way - asked).norm() <= kExact, "another way than the hand's");
    } else if (is_new) {
      Demand((*arm_.target() - tip).norm() <= kExact, "an engagement that moves the tool");
    }
    followed_ = command;
    followed_target_ = *arm_.target();
  }

  Choices choices_;
  Rules rules_;
  CheckedArm arm_{&rules_};
  ManipulatorOptions limits_;
  OperatorPort port_{arm_, TeleopTransform{}, limits_, kDeadAfter};
  ContactState contact_{Vector3d::Zero(), 0, kOutward};
  Time now_ = Time{} + Seconds(100);
  Vector3d hand_{0, 0, 0};
  std::uint64_t sequence_ = 0;
  std::uint32_t largest_epoch_ = 0;   // largest epoch that the port has reported
  std::uint32_t last_epoch_ = 0;      // used up by a stop
  bool is_open_ = false;              // the clutch was open since then
  std::uint32_t followed_epoch_ = 0;  // of the last motion
  // Last command of an uninterrupted motion; its target is the next member.
  std::optional<OperatorCommand> followed_;
  Vector3d followed_target_{0, 0, 0};
};

}  // namespace

void RunArm(Choices choices) {
  Sequence(choices).Run();
}

}  // namespace palpate
