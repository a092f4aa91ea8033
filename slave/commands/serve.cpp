#include "slave/commands/serve.h"

#include <condition_variable>
#include <cstdio>
#include <mutex>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "shared/link/loopback.h"
#include "shared/scene/scene_loader.h"
#include "slave/pipeline/vision_slave.h"
#include "slave/service/server.h"

namespace palpate {
namespace {

void Introduce(const VisionSlave& slave) {
  const SlaveDescription d = slave.Describe();
  spdlog::info("{}: {} {} with {} elements, {} dof, precomputed in {:.0f} ms; {}", d.scene.name,
               d.model.kind,
               d.scene.model.plane == Plane::kStress ? "plane stress" : "plane strain",
               d.model.elements, d.model.dof, 1e3 * d.model.precompute_s, d.source);
  const Registration& r = slave.registration();
  if (r.measured) {
    spdlog::info("rest surface found in the picture: {} points, {:.3f} px rms", r.points, r.rms_px);
  }
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
  VisionSlave slave(LoadScene(options.scene, options.overrides));
  Introduce(slave);
  Server server(slave, options.listen, options.insecure);
  fmt::print("listening on {}\n", server.address());
  std::fflush(stdout);
  WaitFor(stop);
  spdlog::info("stopping");
  server.Stop();
  return 0;
}

}  // namespace palpate
