#include "slave/commands/serve.h"

#include <condition_variable>
#include <cstdio>
#include <memory>
#include <mutex>
#include <string>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "shared/link/loopback.h"
#include "slave/pipeline/camera/vision_slave.h"
#include "slave/pipeline/fingertips/tactile_slave.h"
#include "slave/pipeline/points/stereo_slave.h"
#include "slave/scene/scene_loader.h"
#include "slave/service/server.h"

namespace palpate {
namespace {

void Introduce(const SlaveDescription& d, const std::string& model) {
  spdlog::info("{}: {} with {} elements, {} dof, precomputed in {:.0f} ms; {}", d.scene.name, model,
               d.model.elements, d.model.dof, 1e3 * d.model.precompute_s, d.source);
}

// Of a rig: what decides how well it sees depth.
std::string InWords(const StereoRig& rig) {
  return fmt::format("two cameras {:.3g} mm apart, focal length {:.0f} px, {} x {} px",
                     1e3 * rig.baseline(), rig.left.fx, rig.left.size[0], rig.left.size[1]);
}

std::string InWords(const PointTracking& points) {
  switch (points.track) {
    case PointTracking::Track::kDots:
      return fmt::format("an array of {} dots is followed", points.count);
    case PointTracking::Track::kTexture:
      return fmt::format("{} windows of texture are followed",
                         points.at.empty() ? fmt::format("up to {}", points.count)
                                           : fmt::format("{}", points.at.size()));
    case PointTracking::Track::kSurface:
      break;
  }
  return "the surface is followed where depth pictures show it";
}

std::unique_ptr<Slave> StartWithCamera(const Scene& scene) {
  auto slave = std::make_unique<VisionSlave>(scene);
  const SlaveDescription d = slave->Describe();
  Introduce(d, d.model.kind +
                   (d.scene.model.plane == Plane::kStress ? " plane stress" : " plane strain"));
  const Registration& r = slave->registration();
  if (r.measured) {
    spdlog::info("rest surface found in the picture: {} points, {:.3f} px rms", r.points, r.rms_px);
  }
  return slave;
}

std::unique_ptr<Slave> StartWithFingertips(const Scene& scene) {
  auto slave = std::make_unique<TactileSlave>(scene);
  const SlaveDescription d = slave->Describe();
  Introduce(d, d.model.kind);
  spdlog::info("rest values come from the first {} samples: nothing may touch the fingertips yet",
               d.scene.sense.tactile->rest_samples);
  return slave;
}

std::unique_ptr<Slave> StartWithEyes(const Scene& scene) {
  auto slave = std::make_unique<StereoSlave>(scene);
  const SlaveDescription d = slave->Describe();
  Introduce(d, d.model.kind);
  if (scene.sense.stereo) spdlog::info("{}", InWords(slave->rig()));
  spdlog::info("{}", InWords(*scene.sense.points));
  spdlog::info("the rest frame comes from the first {}: nothing may touch the object yet",
               slave->rest_pictures() == 1 ? "pair of pictures"
                                           : fmt::format("{} pictures", slave->rest_pictures()));
  if (!EstimatesForce(scene)) spdlog::info("{}", d.model_reason);
  return slave;
}

std::unique_ptr<Slave> StartSlave(const Scene& scene) {
  if (scene.sense.tactile) return StartWithFingertips(scene);
  if (HasEyes(scene.sense)) return StartWithEyes(scene);
  return StartWithCamera(scene);
}

void WaitFor(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any changed;
  std::unique_lock lock(mutex);
  changed.wait(lock, stop, [] { return false; });
}

}  // namespace

int RunServe(const ServeOptions& options, const std::stop_token& stop) {
  RequireLoopbackUnless(options.insecure, ParseEndpoint(options.listen));
  const std::unique_ptr<Slave> slave = StartSlave(LoadScene(options.scene, options.overrides));
  Server server(*slave, options.listen, options.insecure);
  fmt::print("listening on {}\n", server.address());
  std::fflush(stdout);
  WaitFor(stop);
  spdlog::info("stopping");
  server.Stop();
  return 0;
}

}  // namespace palpate
