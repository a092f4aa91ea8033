#include "slave/pipeline/base/sense_recorder.h"
#include "slave/pipeline/teleop/live_slave.h"
#include "slave/simulator/environment/simulated_environment.h"

namespace palpate {
namespace {

// One camera finds tip and outline in any picture; fingertips and followed points need every
// sample. A film plays on, and who records wants all of it.
bool MayRest(const Scene& scene, const SensingPipeline& sense, bool is_simulated) {
  const bool is_one_camera = scene.sense.Find<CameraOptions>() && !scene.sense.Find<Tactile>() &&
                             !HasStereoOrDepth(scene.sense);
  return is_one_camera && (is_simulated || sense.health());
}

}  // namespace

std::unique_ptr<Slave> MakeLiveSlave(const Scene& scene, const std::filesystem::path& state_folder,
                                     SenseRecorder* recorder, const ModelChooser& choose) {
  std::unique_ptr<SimulatedEnvironment> environment = MakeSimulatedEnvironment(scene);
  Manipulator::OnStep on_step;
  if (environment) {
    environment->SolveAhead();
    on_step = [site = environment.get()](const Eigen::Vector3d& p_S_tip) {
      site->MoveTool(p_S_tip, Patience::kNone);
    };
  }
  std::unique_ptr<Manipulator> manipulator = MakeManipulator(scene, on_step);
  if (environment) environment->MoveTool(manipulator->Tip(), Patience::kNone);
  Pace pace{.tap = recorder};
  if (recorder != nullptr) {
    if (environment) pace.p_S_tip = environment->truth().p_S_tip;
    recorder->Begin(pace.p_S_tip);
  }
  std::unique_ptr<SensingPipeline> sense = MakeSensingPipeline(scene, pace, environment.get());
  const bool may_rest = recorder == nullptr && MayRest(scene, *sense, environment != nullptr);
  if (recorder != nullptr) sense = recorder->Watch(std::move(sense));
  auto slave = std::make_unique<LiveSlave>(scene, std::move(environment), std::move(manipulator),
                                           std::move(sense), choose);
  if (may_rest) slave->AllowRest();
  if (!state_folder.empty()) slave->KeepStopIn(state_folder);
  return slave;
}

}  // namespace palpate
