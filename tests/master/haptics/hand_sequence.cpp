#include "tests/master/haptics/hand_sequence.h"

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <optional>

#include "shared/wire/patch_message.h"
#include "tests/master/haptics/port_energy.h"
#include "tests/master/haptics/rig.h"
#include "tests/master/haptics/wall_patch.h"

namespace palpate {
namespace {

constexpr double kHandTick = 0.001;   // [s]
constexpr double kHandSpeed = 0.3;    // [m/s]
constexpr double kHandChange = 0.01;  // of its speed in a tick [m/s]
constexpr int kMaxTicks = 5000;       // [ticks]

using Falsification =
    std::function<void(SlaveState* state, int n)>;  // n: states since the beginning

// Draws a false value in a state: its size, and in which of every 2 `period` states it occurs.
Falsification DrawFalsification(Choices* choices) {
  const Eigen::Vector3d by = choices->Within(1);
  const double wild = choices->Wild();
  const int period = 1 + choices->Byte() / 4;
  const std::array<Falsification, 16> falsifications{
      [=](SlaveState* s, int) { s->local_model.stiffness(1, 1) = wild; },
      [=](SlaveState* s, int) { s->local_model.stiffness += 5e3 * by * by.transpose(); },
      [=](SlaveState* s, int) { s->local_model.stiffness(0, 1) += 5e3 * by.x(); },
      [=](SlaveState* s, int) { s->local_model.reference += 0.02 * by; },
      [=](SlaveState* s, int) { s->local_model.normal = by; },
      [=](SlaveState* s, int) { s->local_model.force = 5 * by; },
      [=](SlaveState* s, int) { s->local_model.valid_radius = wild; },
      [](SlaveState* s, int n) { s->local_model.revision = static_cast<std::uint32_t>(n + 2); },
      [=](SlaveState* s, int) { s->force = 5 * by; },
      [=](SlaveState* s, int) { s->force = Eigen::Vector3d(0, wild, 0); },
      [](SlaveState* s, int) { s->force.reset(); },
      [=](SlaveState* s, int) { s->offset += 0.1 * by; },
      [=](SlaveState* s, int) { s->sensed_at += Seconds(2 * by.x()); },
      [=](SlaveState* s, int) { s->epoch += by.x() > 0 ? 1 : 1000; },
      [=](SlaveState* s, int) { s->phase = static_cast<Phase>(1 + period % 5); },
      [=](SlaveState* s, int) { s->validity = static_cast<Validity>(period % 6); },
  };
  return [falsify = choices->Among(falsifications), period](SlaveState* state, int n) {
    if (n / period % 2 == 0) falsify(state, n);
  };
}

// Returns a patch as the link would deliver it; nullopt if the message conversion refuses it.
std::optional<ReceivedPatch> DrawPatch(Choices* choices, std::uint32_t epoch) {
  ReceivedPatch drawn = WallPatch(choices->Among(std::array<double, 4>{60, 600, 2000, 1e6}), epoch,
                                  choices->Within(-0.008, 0.004));
  PatchLaw& law = drawn.law;
  law.revision = choices->Byte();
  law.count = 1 + static_cast<int>(choices->Below(kLawPoints));
  for (double& ratio : law.ratios) ratio = choices->Within(0, 4);
  law.velocity = 0.05 * choices->Within(1);
  law.velocity_error = choices->Within(0, 0.01);
  law.offset = 0.002 * choices->Within(1);
  if (choices->Coin()) law.friction = choices->Within(0, 2);
  if (choices->Byte() == 0) law.ratios[0] = choices->Wild();
  law.sensed_at = Time{std::chrono::hours(1)} + Seconds(1000);
  v1::SurfacePatch patch;
  v1::PatchLaw of_it;
  ToProto(drawn.patch, &patch);
  ToProto(law, &of_it);
  std::string reason;
  const auto read = FromProto(patch, &reason);
  const auto read_law = FromProto(of_it, &reason);
  if (!read || !read_law) return std::nullopt;
  return ReceivedPatch{*read, *read_law};
}

class Sequence {
 public:
  explicit Sequence(Choices choices)
      : choices_(choices),
        rig_({.K = choices_.Among(std::array<double, 4>{60, 600, 1900, 5000}),
              .delay = choices_.Among(std::array<double, 4>{0, 0.005, 0.05, 0.2}),
              .sensor_rate = choices_.Among(std::array<double, 2>{60, 500})},
             static_cast<RenderMode>(choices_.Below(3)), kForceLimit, kSlewLimit) {
    rig_.slave.falsify = [this](SlaveState* state) {
      for (const Falsification& falsify : falsifications_) falsify(state, states_);
      ++states_;
    };
  }

  void Run() {
    while (!choices_.over() && ticks_ < kMaxTicks) {
      Change();
      for (int left = choices_.Byte(); left >= 0; --left) Tick();
    }
  }

 private:
  void Change() {
    switch (choices_.Below(12)) {
      case 0:
      case 1:
        aim_ = kHandSpeed * choices_.Within(1);
        return;
      case 2:
        aim_ = Eigen::Vector3d(0, choices_.Within(-kHandSpeed, kHandSpeed), 0);
        return;
      case 3:
      case 4:
        puppet_.reading.engaged = choices_.Byte() % 4 != 0;
        return;
      case 5:
      case 6:
        falsifications_[choices_.Below(falsifications_.size())] = DrawFalsification(&choices_);
        return;
      case 7:
        falsifications_[choices_.Below(falsifications_.size())] = [](SlaveState*, int) {};
        return;
      case 8:
        if (const auto patch = DrawPatch(&choices_, rig_.loop.record().epoch)) {
          rig_.patches.Put(*patch);
        }
        return;
      case 9:
        return ChangeSettings();
      case 10:
        return OperatorAct();
      default:
        return Break();
    }
  }
  void ChangeSettings() {
    constexpr std::array<double, 5> kScales{1e-3, 0.1, 1, 10, 1e6};
    RemoteSettings settings{choices_.Byte(), {}, choices_.Within(0.1, 10)};
    settings.transform.position_scale = choices_.Among(kScales);
    settings.transform.force_scale = choices_.Among(kScales);
    settings.dead_after = choices_.Within(0, 1);
    rig_.settings.Put(settings);
  }
  void OperatorAct() {
    OperatorRequests& requests = rig_.requests;
    switch (choices_.Below(4)) {
      case 0:
        requests.render = static_cast<RenderMode>(choices_.Below(3));
        return;
      case 1:
        ++requests.tares;
        return;
      case 2:
        requests.clutched = choices_.Coin();
        return;
      default:
        requests.force_limit = choices_.Within(1, 4);
    }
  }
  void Break() {
    VirtualSlave& slave = rig_.slave;
    switch (choices_.Below(6)) {
      case 0:
        slave.silent = !slave.silent;
        return;
      case 1:
        slave.forgets = !slave.forgets;
        return;
      case 2:
        slave.forced_phase = choices_.Coin() ? Phase::kEstop : Phase::kReady;
        return;
      case 3:
        slave.set_K(choices_.Within(10, 5000));
        return;
      case 4:
        if (choices_.Byte() % 8 == 0) rig_.loop.stops().Request();
        return;
      default:
        is_broken_ = true;
    }
  }
  // Moves the simulated device, which has mass and a limited workspace.
  void Tick() {
    ++ticks_;
    DeviceReading& hand = puppet_.reading;
    constexpr double kReach = 0.05;  // [m]
    for (int i = 0; i < 3; ++i) {
      if (hand.p_M[i] * aim_[i] > 0 && std::abs(hand.p_M[i]) > kReach) aim_[i] = -aim_[i];
    }
    const Eigen::Vector3d change = aim_ - hand.v_M;
    const double part = std::min(1.0, kHandChange / std::max(change.norm(), 1e-12));
    hand.v_M += part * change;
    hand.p_M += kHandTick * hand.v_M;
    const DeviceReading true_reading = hand;
    if (is_broken_) hand.p_M.x() = std::numeric_limits<double>::quiet_NaN();
    is_broken_ = false;
    const TickRecord& record = rig_.Tick(puppet_);
    port_.Add(record);
    Demand(record.chain.sent.allFinite(), "a force that is no number");
    Demand(port_.peak() <= kForceLimit * (1 + 1e-12), "more force than the limit");
    Demand(port_.step() <= kSlewLimit * (1 + 1e-9), "a faster change than the limit");
    Demand(port_.min() >= -kEnergyLimit, "energy for nothing");
    hand = true_reading;
  }

  Choices choices_;
  Rig rig_;
  Puppet puppet_;
  Eigen::Vector3d aim_{0, 0, 0};  // target velocity of the device [m/s]
  std::array<Falsification, 4> falsifications_{[](SlaveState*, int) {}, [](SlaveState*, int) {},
                                               [](SlaveState*, int) {}, [](SlaveState*, int) {}};
  PortEnergy port_{PortEnergy::LeftInContact::kReturned};
  int states_ = 0, ticks_ = 0;
  bool is_broken_ = false;  // the device, for a tick
};

}  // namespace

void RunHand(Choices choices) {
  Sequence(choices).Run();
}

}  // namespace palpate
