#include "shared/state/driven_clock.h"
#include "slave/live/live_slave.h"
#include "slave/pipeline/base/sense_recorder.h"
#include "slave/pipeline/camera/preview_sense.h"

namespace palpate {
namespace {

// Sensing with one camera can skip images while idle, because it locates tip and outline in any
// image. Fingertips and tracked points need every sample, as do videos and recordings.
bool MayIdle(const Scene& scene, const SensingPipeline& sense) {
  const bool is_one_camera = scene.sense.Find<CameraOptions>() && !scene.sense.Find<Tactile>() &&
                             !HasStereoOrDepth(scene.sense);
  return is_one_camera && sense.health();
}

}  // namespace

std::unique_ptr<LiveSlave> MakeLiveSlave(Scene scene, const std::filesystem::path& state_folder,
                                         SenseRecorder* recorder, const FrameOpener& open,
                                         Progress* progress) {
  StreamSimulated(&scene);
  std::unique_ptr<Manipulator> manipulator = MakeManipulator(scene);
  const SenseInputs inputs{.tap = recorder,
                           .open = open,
                           .progress = progress,
                           .solves_aside = !DrivenClock::is_active()};
  if (recorder != nullptr) recorder->Begin();
  std::unique_ptr<SensingPipeline> sense = MakeSensingPipeline(scene, inputs);
  const bool may_idle = recorder == nullptr && MayIdle(scene, *sense);
  if (recorder != nullptr) sense = recorder->Watch(std::move(sense));
  auto slave = std::make_unique<LiveSlave>(scene, std::move(manipulator), std::move(sense));
  slave->ReportRecorder(recorder);
  if (may_idle) slave->AllowIdle();
  if (!state_folder.empty()) slave->KeepStopIn(state_folder);
  return slave;
}

std::unique_ptr<LiveSlave> MakePlayedSlave(const Scene& scene, SamplePlayer& player,
                                           std::unique_ptr<PlayedManipulator> manipulator) {
  auto sense = MakeSensingPipeline(scene, {.player = &player});
  return std::make_unique<LiveSlave>(scene, std::move(manipulator), std::move(sense));
}

std::unique_ptr<LiveSlave> MakePreviewSlave(const Camera& camera, const FrameOpener& open) {
  Scene scene;
  scene.sense.Set(CameraOptions{.camera = camera});
  scene.manipulator.source = ManipulatorOptions::Source::kNone;
  return std::make_unique<LiveSlave>(scene, MakeManipulator(scene),
                                     std::make_unique<PreviewSense>(open({})));
}

}  // namespace palpate
