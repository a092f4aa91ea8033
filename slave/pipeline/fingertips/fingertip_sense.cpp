#include "slave/pipeline/fingertips/fingertip_sense.h"

#include <stdexcept>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "slave/capture/tactile_inbox.h"
#include "slave/capture/tactile_recording.h"
#include "slave/mechanics/make_model.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kPoseResolution = 10e-6;  // of what tells where a fingertip is [m]

std::unique_ptr<TactileSource> Open(const Scene& scene, const Pace& pace, World* world) {
  if (world != nullptr) return world->OpenFingertips(scene, pace);
  if (scene.sense.Find<Tactile>()->source == Tactile::Source::kRecording) {
    return OpenTactileRecording(scene, pace.is_live);
  }
  if (!pace.is_live) {
    throw std::invalid_argument(
        scene.file.string() +
        ": sense.tactile.source = stream: accepted here is a recording, or simulated");
  }
  return std::make_unique<TactileInbox>(*scene.sense.Find<Tactile>());
}

}  // namespace

FingertipSense::FingertipSense(const Scene& scene, const Pace& pace, World* world)
    : FingertipSense(scene, Open(scene, pace, world), LoadSenses(scene)) {}

FingertipSense::FingertipSense(const Scene& scene, std::unique_ptr<TactileSource> source,
                               TactileSenses senses)
    : scene_(scene), source_(std::move(source)), estimator_(scene, std::move(senses)) {}

bool FingertipSense::Acquire(const std::stop_token& stop) {
  const std::optional<TactileFrame> frame = source_->Next(stop);
  if (frame) next_ = *frame;
  return frame.has_value();
}

const ContactEstimate& FingertipSense::Estimate(const Vector3d& p_S_tip) noexcept {
  return estimator_.Feel(next_, p_S_tip);
}

LocalModel FingertipSense::LocalModelAt(const Vector3d& p_S_tip) noexcept {
  return estimator_.LocalAt(p_S_tip);
}

BoundaryShape FingertipSense::Shape(bool nodal_forces) {
  return estimator_.Shape(nodal_forces);
}

std::unique_ptr<Rebuilt> FingertipSense::Prepare(const Scene& changed) const {
  return TactileEstimator::Prepare(changed);
}

void FingertipSense::Adopt(std::unique_ptr<Rebuilt> rebuilt, const Scene& changed) {
  estimator_.Adopt(std::unique_ptr<TactileBody>(static_cast<TactileBody*>(rebuilt.release())),
                   changed);
}

SenseInfo FingertipSense::info() const {
  SenseInfo info;
  info.source = source_->description();
  info.samples = "samples";
  info.tip_resolution = kPoseResolution;
  info.model.kind = "none";
  info.reason = "nothing says where the fingertips are, so nothing deforms";
  if (estimator_.body() != nullptr) {
    info.model = estimator_.body()->info();
    info.reason = ChooseModel(scene_).reason;
  }
  info.remarks.push_back(fmt::format(
      "rest values come from the first {} samples: nothing may touch the fingertips yet",
      scene_.sense.Find<Tactile>()->rest_samples));
  info.changeable = {ObjectClass::kVolume, 0, false, true};
  return info;
}

std::vector<StageTimes> FingertipSense::Stages() const {
  const TactileTimes& times = estimator_.times();
  return {TimesOf("tactile", times.tactile), TimesOf("contact", times.contact),
          TimesOf("mechanics", times.mechanics), TimesOf("total", times.total)};
}

TactileInbox* FingertipSense::inbox() {
  return dynamic_cast<TactileInbox*>(source_.get());
}

}  // namespace palpate
