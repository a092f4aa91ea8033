#include "slave/checks/fingertips/fingertip_checks.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

// Checks that electrodes work and match each other, now and in the network's window, and that
// samples do not repeat.
class ElectrodesCheck final : public Check<FingertipSample> {
 public:
  void Examine(const FingertipSample& sample, Findings* findings) noexcept override {
    const Fingertip& tip = sample.tip;
    const StuckElectrodes& stuck = tip.stuck();
    const auto fail = [&](bool is_so, FailedCheck check, std::string_view why) {
      if (is_so) findings->Fail(check, why);
    };
    fail(tip.touch().place.is_flawed, FailedCheck::kElectrode, "electrodes are saturated or dead");
    fail(stuck.are_frozen() || stuck.are_all(), FailedCheck::kFrozen,
         "all channels are constant: the sensor is dead or its driver repeats samples");
    fail(stuck.count() > 0 && !tip.signals(), FailedCheck::kElectrode,
         "an electrode or channel is constant: it is dead");
    if (const ChannelSignals* channels = tip.channels(); channels != nullptr) {
      fail(!channels->fault().empty(), FailedCheck::kElectrode, channels->fault());
    }
    fail(tip.holds_flaw(), FailedCheck::kElectrode, "a faulty sample in the window");
    if (!tip.signals() || tip.misses()) return;
    // d^2 / n of n signals has the mean 1 and the variance 2 / n.
    sample.consistency->Add({FailedCheck::kElectrode, "the electrodes do not match each other",
                             std::max(0.0, tip.signals()->mahalanobis2() - 1),
                             std::sqrt(2.0 / kPatternSignals)});
  }
};

// Checks that fingertip and force are like those of the network's training.
class ResponseCheck final : public Check<FingertipSample> {
 public:
  void Examine(const FingertipSample& sample, Findings* findings) noexcept override {
    const FingerTouch& touch = sample.tip.touch();
    const NetworkInfo& network = sample.tip.network();
    const double force = touch.force_F ? touch.force_F->norm() : 0;
    if (network.learnt_force > 0 && force > network.learnt_force) {
      findings->Fail(FailedCheck::kModelRange,
                     "the force is beyond the training range of the network");
    }
    if (sample.tip.channels() != nullptr && sample.tip.channels()->is_beyond()) {
      findings->Fail(FailedCheck::kModelRange,
                     "a channel is beyond its range in the training of the network");
    }
    const auto fail = [&](bool is_so, std::string_view why) {
      if (is_so) findings->Fail(FailedCheck::kTransfer, why);
    };
    fail(!touch.touching && !touch.place.usable() && force > kUnseenTouch * network.sigma.norm(),
         "there is a force, but no contact point");
    const SignalModel* model = sample.tip.signals();
    if (model == nullptr || sample.tip.misses()) return;
    fail(model->noise().since_start() < kFallen,
         "the noise of the electrodes is lower than at the start: their gain has fallen");
    fail(model->noise().relative() < kQuietest,
         "the noise of the electrodes is lower than in the training data: their gain is lower");
    sample.consistency->Add({FailedCheck::kTransfer, "the pressure does not match the electrodes",
                             model->pressure_residual(), kPressureSigma});
  }

 private:
  // Sigma of the pressure minus its prediction, in standard deviations of the model. The model
  // covers all kinds of contacts, so the deviation of a single contact persists [-]. [tuned:
  // pressure stuck]
  static constexpr double kPressureSigma = 1.3;
  // Smallest noise of the electrodes relative to that at the start; real fingers within a minute:
  // 0.95 to 1.1 [-].
  static constexpr double kFallen = 0.85;
  // Smallest ratio to the value of the training; five real fingers have 0.83 to 1.17 [-]. [tuned:
  // gain of all wrong]
  static constexpr double kQuietest = 0.8;
  // Largest force without an active electrode, relative to the error of the network [sigma].
  static constexpr double kUnseenTouch = 3;
};

// Checks that there is no contact while the baseline is measured. Otherwise the baseline is wrong
// until it is measured again.
class RestContactCheck final : public Check<FingertipSample> {
 public:
  void Examine(const FingertipSample& sample, Findings* findings) noexcept override {
    if (sample.tip.pressure() < kBelowBaseline) {
      findings->Fail(FailedCheck::kRestDrift,
                     "the pressure is below its baseline: something touched the fingertip while "
                     "the baseline was measured");
    }
    if (!sample.tip.baseline_fault().empty()) {
      findings->Fail(FailedCheck::kRestDrift, sample.tip.baseline_fault());
    }
    if (sample.tip.channels() != nullptr && sample.tip.channels()->is_opposite()) {
      findings->Fail(FailedCheck::kRestDrift,
                     "a channel is on the other side of its baseline than contacts move it: "
                     "something touched the sensor while the baseline was measured, or it has "
                     "drifted");
    }
    if (IsPulling(sample.tip)) {
      findings->Fail(FailedCheck::kRestDrift,
                     "the force pulls: something touched the sensor while the baseline was "
                     "measured");
    }
    const bool is_baseline = sample.tip.touch().is_baseline;
    if (is_baseline && !was_baseline_) was_inside_ = false;
    was_baseline_ = is_baseline;
    if (is_baseline && sample.depth && *sample.depth > kInside) was_inside_ = true;
    if (!was_inside_) return;
    findings->Fail(FailedCheck::kRestDrift,
                   "the pose was inside the object while the baseline was taken");
  }

 private:
  // For a sensor without pressure, a baseline that was measured in contact shows only by the force:
  // after the contact it pulls for long, beyond the network's error. Then all forces are wrong
  // until the next baseline.
  bool IsPulling(const Fingertip& tip) noexcept {
    const FingerTouch& touch = tip.touch();
    const NetworkInfo& network = tip.network();
    if (network.channels.are_electrodes()) return false;
    if (touch.is_baseline) pulling_ = 0;
    const double error = std::hypot(network.rest_sigma, network.sigma.z());
    const bool pulls = touch.force_F && touch.force_F->z() > kPull * error;
    const double max_pulling = kPullTime * network.rate;
    if (pulling_ < max_pulling) pulling_ = pulls ? pulling_ + 1 : 0;
    return pulls || pulling_ >= max_pulling;
  }

  static constexpr double kPull = 5;        // [sigma]
  static constexpr double kPullTime = 0.5;  // longer than a contact adheres while it opens [s]
  double pulling_ = 0;                      // samples
  // Pressure above its baseline; five real fingers: -2 after a contact [counts].
  static constexpr double kBelowBaseline = -8;
  // Depth of a pose that is inside the object; foam raises the pressure from 1.7 mm on [m]. [tuned:
  // RestValuesTakenInsideTheObjectAreFlaggedUntilTakenAgain]
  static constexpr double kInside = 2.2e-3;
  bool was_baseline_ = false, was_inside_ = false;
};

// Checks that the contact is on the object according to the pose, and within the range of the
// model.
class PoseCheck final : public Check<FingertipSample> {
 public:
  void Examine(const FingertipSample& sample, Findings* findings) noexcept override {
    if (!sample.misplaced.empty()) findings->Fail(FailedCheck::kPose, sample.misplaced);
    if (!sample.is_beyond_model) return;
    findings->Fail(FailedCheck::kModelRange, "the force is beyond the range of the model");
  }
};

// Compares the force with that of the object's model at this depth.
class ModelForceCheck final : public Check<FingertipSample> {
 public:
  void Examine(const FingertipSample& sample, Findings* /*findings*/) noexcept override {
    if (!sample.force_ratio || !(*sample.force_ratio > 0)) return;
    sample.consistency->Add(
        {FailedCheck::kTransfer, "the force does not match that of the model at this depth",
         std::log(*sample.force_ratio), std::hypot(kModelSigma, sample.force_ratio_sigma)});
  }

 private:
  // Logarithm of a force over that of a model of small strain [-]. [tuned: object softer than
  // stated]
  static constexpr double kModelSigma = 0.25;
};

// Compares the fingertip's position with the encoders; a difference means that the samples are of
// another time.
class FingerEncoderCheck final : public Check<FingertipSample> {
 public:
  void Examine(const FingertipSample& sample, Findings* /*findings*/) noexcept override {
    if (!sample.encoder_error) return;
    sample.consistency->Add({FailedCheck::kArm,
                             "the fingertips are not where the encoders report them",
                             std::max(0.0, *sample.encoder_error), kSigma});
  }

 private:
  // Sigma of the difference between fingertip and encoder pose beyond their lag [m]: a single
  // sample with a difference of half a millimetre fails. [tuned: late]
  static constexpr double kSigma = 7.5e-5;
};

}  // namespace

Checks<FingertipSample> MakeFingertipChecks() {
  Checks<FingertipSample> checks;
  checks.Add(std::make_unique<ElectrodesCheck>());
  checks.Add(std::make_unique<ResponseCheck>());
  checks.Add(std::make_unique<RestContactCheck>());
  checks.Add(std::make_unique<PoseCheck>());
  checks.Add(std::make_unique<ModelForceCheck>());
  checks.Add(std::make_unique<FingerEncoderCheck>());
  return checks;
}

}  // namespace palpate
