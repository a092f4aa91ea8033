#include "slave/commands/serve/serve.h"

#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include <malloc.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "shared/link/loopback.h"
#include "shared/metrics/metrics_page.h"
#include "shared/program/program.h"
#include "slave/commands/program.h"
#include "slave/commands/running_scene.h"
#include "slave/commands/serve/slave_recorder.h"
#include "slave/pipeline/teleop/live_slave.h"
#include "slave/service/server.h"
#include "slave/service/slave_metrics.h"
#include "slave/study/auto_model.h"

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

std::optional<Scene> ChosenAgain(const Scene& scene, const std::stop_token& stop) {
  return study::DecideQuickly(scene, study::RealWorkshop(), study::kQuickBudget, stop);
}

Metrics MetricsOf(const Slave& slave, const Server& server) {
  Metrics metrics = MetricsOf(slave.Status(), server.connections());
  for (Metric& metric : MetricsOfThisProcess()) metrics.push_back(std::move(metric));
  metrics.push_back(
      {"palpate_slave_info",
       "Version of the slave.",
       Metric::Type::kGauge,
       {{Label("version", Version()) + "," + Label("scene", slave.Describe().scene.name), 1}}});
  return metrics;
}

}  // namespace

int RunServe(const ServeOptions& options, StopOnSignal& signals) {
  const std::stop_token stop = signals.token();
  // Each of eight a processor would come to keep a few pictures that nobody needs.
  mallopt(M_ARENA_MAX, 4);
  const bool plain = options.tls.empty();
  RequireLoopbackUnless(options.insecure || !plain, ParseEndpoint(options.listen));
  if (!options.metrics.empty()) MetricsEndpoint(options.metrics, options.insecure);
  if (plain && !IsLoopback(ParseEndpoint(options.listen).host)) {
    spdlog::warn(
        "--insecure: {} serves every client in plain text: anyone who can reach it can move the "
        "tool",
        options.listen);
  }
  const Scene scene = LoadRunningScene(options.scene, options.overrides, SceneUse::kFull, stop);
  const auto recording = OpenRecording(options, scene);
  const auto slave = MakeLiveSlave(scene, options.state_dir,
                                   recording ? &recording->sense() : nullptr, ChosenAgain);
  const SlaveDescription served = slave->Describe();
  Introduce(served);
  const std::string missing = MissingGuards(scene.manipulator);
  if (served.sense.tells_force && !missing.empty()) spdlog::warn("{}", missing);
  Server server(*slave, options.listen, options.insecure, options.tls);
  std::optional<MetricsPage> metrics;
  if (!options.metrics.empty())
    metrics.emplace(options.metrics, options.insecure, [&] { return MetricsOf(*slave, server); });
  if (metrics) spdlog::info("metrics at http://{}/metrics", ToString(metrics->endpoint()));
  malloc_trim(0);  // what only the start needed
  fmt::print("listening on {}\n", server.address());
  std::fflush(stdout);
  signals.OnEmergency([&slave = *slave] { slave.EmergencyStop("by SIGUSR1"); });
  WaitFor(stop);
  signals.OnEmergency(nullptr);
  spdlog::info("stopping");
  server.Stop();
  return 0;
}

}  // namespace palpate
