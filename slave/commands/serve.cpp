#include "slave/commands/serve.h"

#include <condition_variable>
#include <cstdio>
#include <memory>
#include <mutex>
#include <string>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "shared/link/loopback.h"
#include "slave/pipeline/teleop/live_slave.h"
#include "slave/scene/scene_loader.h"
#include "slave/service/server.h"

namespace palpate {
namespace {

void Introduce(const SlaveDescription& d) {
  spdlog::info("{}", d.scene.name);
  for (const std::string& line : Introduction(d.sense)) spdlog::info("{}", line);
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
  const auto slave = MakeLiveSlave(LoadScene(options.scene, options.overrides));
  Introduce(slave->Describe());
  Server server(*slave, options.listen, options.insecure);
  fmt::print("listening on {}\n", server.address());
  std::fflush(stdout);
  WaitFor(stop);
  spdlog::info("stopping");
  server.Stop();
  return 0;
}

}  // namespace palpate
