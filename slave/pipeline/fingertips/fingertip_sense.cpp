// Results of a run over fingertips: a row per sample and fingertip, and the errors of the forces.
#include "slave/pipeline/fingertips/fingertip_sense.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "slave/capture/tactile_inbox.h"
#include "slave/capture/tactile_recording.h"
#include "slave/mechanics/factory/choose_model.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/pipeline/manipulator_agreement/arm_lag.h"
#include "slave/pipeline/offline/offline_report.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

// If the pose of a fingertip is unknown, its positions are empty and its force is in frame F.
StateRow RowOf(const FingerEstimate& finger, const std::string& name,
               const ContactEstimate& estimate, Time start) {
  return {SecondsBetween(start, estimate.sensed_at),
          estimate.sample,
          name,
          finger.has_pose ? finger.p_S_apex : kUnknownVector,
          finger.p_S_contact.value_or(kUnknownVector),
          finger.force,
          finger.sigma,
          finger.validity,
          finger.check,
          std::nullopt,
          estimate.details,
          std::nullopt,
          0};
}

class FingertipOfflineReport final : public OfflineReport {
 public:
  explicit FingertipOfflineReport(const FingertipSense& sense) : sense_(sense) {}

  std::vector<StateRow> Add(Time start, const Truth* truth) override {
    const TactileEstimator& estimator = sense_.estimator();
    std::vector<StateRow> rows;
    for (int i = 0; i < estimator.finger_count(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const std::string& name = sense_.scene().sense.Find<Tactile>()->fingers[k].name;
      rows.push_back(RowOf(estimator.finger(i), name, estimator.estimate(), start));
      if (truth != nullptr) rows.back().true_force = truth->fingers[k].force;
    }
    rows.front().moment = estimator.estimate().moment;
    rows.front().moment_sigma = estimator.estimate().moment_sigma;
    if (truth != nullptr) Compare(*truth);
    return rows;
  }

  void RequireComplete(std::uint64_t samples) const override {
    const int rest = sense_.scene().sense.Find<Tactile>()->rest_samples;
    if (samples >= static_cast<std::uint64_t>(rest)) return;
    throw std::runtime_error(
        fmt::format("{}: {} samples are fewer than the {} of `rest`: no force can be estimated",
                    sense_.info().source, samples, rest));
  }

  void Finish(OfflineSummary* summary) const override {
    const TactileEstimator& estimator = sense_.estimator();
    summary->own["fingers"] = estimator.finger_count();
    summary->own["network"] =
        estimator.network() != nullptr ? estimator.network()->info().architecture : "";
    summary->own["localiser"] = estimator.localiser().name();
  }

 private:
  // The model's force at the true depth is the force that the master would render of the first
  // fingertip.
  void Compare(const Truth& truth) {
    const TactileEstimator& estimator = sense_.estimator();
    for (int i = 0; i < estimator.finger_count(); ++i) {
      const FingerTruth& finger = truth.fingers[static_cast<std::size_t>(i)];
      compared_.push_back({estimator.finger(i).force.value_or(kUnknownVector), finger.force});
      if (i > 0) continue;
      compared_.back().model_at_truth = ForceAt(estimator.estimate().local_model, finger.depth);
    }
  }

  const FingertipSense& sense_;
};

constexpr double kPoseResolution = 10e-6;  // of the measured position of a fingertip [m]

std::unique_ptr<TactileSource> OpenFingerSource(const Scene& scene, const SenseInputs& inputs) {
  if (inputs.player != nullptr) return inputs.player->OpenFingertips();
  if (scene.sense.Find<Tactile>()->source == Tactile::Source::kRecording) {
    return OpenTactileRecording(scene);
  }
  return std::make_unique<TactileInbox>(*scene.sense.Find<Tactile>());
}

std::unique_ptr<TactileSource> OpenTappedFingers(const Scene& scene, const SenseInputs& inputs) {
  return Tapped(OpenFingerSource(scene, inputs), inputs.tap);
}

}  // namespace

std::unique_ptr<OfflineReport> FingertipSense::OpenOfflineReport(const GroundTruth* /*truth*/) {
  return std::make_unique<FingertipOfflineReport>(*this);
}

FingertipSense::FingertipSense(const Scene& scene, const SenseInputs& inputs)
    : FingertipSense(scene, OpenTappedFingers(scene, inputs), LoadSenses(scene)) {}

FingertipSense::FingertipSense(const Scene& scene, std::unique_ptr<TactileSource> source,
                               TactileSenses senses)
    : scene_(scene), source_(std::move(source)), estimator_(scene, std::move(senses)) {}

bool FingertipSense::Acquire(const std::stop_token& stop) {
  const std::optional<TactileFrame> frame = source_->Next(stop);
  if (frame) next_ = *frame;
  return frame.has_value();
}

const ContactEstimate& FingertipSense::Estimate(const TipReading& encoders) noexcept {
  if (!encoders.frame) return estimator_.Estimate(next_, encoders.p_S_tip);
  if (encoders.frame != encoder_frame_) estimator_.ForgetEncoders();
  encoder_frame_ = encoders.frame;
  return estimator_.Estimate(next_, encoders.p_S_tip, kArmLag);
}

void FingertipSense::Adopt(std::unique_ptr<PreparedModel> prepared, const Scene& changed) {
  estimator_.Adopt(std::unique_ptr<TactileBody>(static_cast<TactileBody*>(prepared.release())),
                   changed);
}

SenseInfo FingertipSense::info() const {
  SenseInfo info;
  info.source = source_->description();
  info.samples = "samples";
  info.tip_resolution = kPoseResolution;
  info.model.kind = "none";
  info.reason = "the scene has no poses of the fingertips, so the object is not deformed";
  if (estimator_.body() != nullptr) {
    info.model = estimator_.body()->info();
    info.reason = ChooseModel(scene_).reason;
  }
  info.remarks.push_back(fmt::format(
      "the baseline comes from the first {} samples: nothing may touch the fingertips until then",
      scene_.sense.Find<Tactile>()->rest_samples));
  info.object = ObjectClass::kVolume;
  return info;
}

std::vector<StageTimes> FingertipSense::Stages() const {
  const TactileTimes& times = estimator_.times();
  return {TimesOf("tactile", times.tactile), TimesOf("checks", times.checks),
          TimesOf("contact", times.contact), TimesOf("mechanics", times.mechanics),
          TimesOf("total", times.total)};
}

TactileInbox* FingertipSense::inbox() {
  return dynamic_cast<TactileInbox*>(Untapped(source_.get()));
}

}  // namespace palpate
