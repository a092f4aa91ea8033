#include "slave/commands/serve.h"

#include <condition_variable>
#include <cstdio>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "shared/link/loopback.h"
#include "shared/scene/scene_loader.h"
#include "slave/pipeline/tactile_slave.h"
#include "slave/pipeline/vision_slave.h"
#include "slave/service/server.h"

namespace palpate {
namespace {

void Introduce(const SlaveDescription& d, const std::string& model) {
  spdlog::info("{}: {} with {} elements, {} dof, precomputed in {:.0f} ms; {}", d.scene.name, model,
               d.model.elements, d.model.dof, 1e3 * d.model.precompute_s, d.source);
}

std::unique_ptr<Slave> StartWithCamera(Scene scene) {
  auto slave = std::make_unique<VisionSlave>(std::move(scene));
  const SlaveDescription d = slave->Describe();
  Introduce(d, d.model.kind +
                   (d.scene.model.plane == Plane::kStress ? " plane stress" : " plane strain"));
  const Registration& r = slave->registration();
  if (r.measured) {
    spdlog::info("rest surface found in the picture: {} points, {:.3f} px rms", r.points, r.rms_px);
  }
  return slave;
}

std::unique_ptr<Slave> StartWithFingertips(Scene scene) {
  auto slave = std::make_unique<TactileSlave>(std::move(scene));
  const SlaveDescription d = slave->Describe();
  Introduce(d, d.model.kind);
  spdlog::info("rest values come from the first {} samples: nothing may touch the fingertips yet",
               d.scene.sense.tactile->rest_samples);
  return slave;
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
  Scene scene = LoadScene(options.scene, options.overrides);
  const std::unique_ptr<Slave> slave = scene.sense.tactile ? StartWithFingertips(std::move(scene))
                                                           : StartWithCamera(std::move(scene));
  Server server(*slave, options.listen, options.insecure);
  fmt::print("listening on {}\n", server.address());
  std::fflush(stdout);
  WaitFor(stop);
  spdlog::info("stopping");
  server.Stop();
  return 0;
}

}  // namespace palpate
