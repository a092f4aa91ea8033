#include "slave/commands/serve/serve.h"

#include <algorithm>
#include <condition_variable>
#include <cstdio>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <utility>

#include <malloc.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include "shared/link/loopback.h"
#include "shared/metrics/metrics_page.h"
#include "shared/nats/nats_connection.h"
#include "shared/program/program.h"
#include "shared/text/text.h"
#include "slave/commands/program.h"
#include "slave/commands/running_scene.h"
#include "slave/commands/serve/setup_session.h"
#include "slave/live/live_slave.h"
#include "slave/recording/sense_recording.h"
#include "slave/service/server.h"
#include "slave/service/slave_metrics.h"
#include "slave/study/auto_model.h"

namespace palpate {
namespace {

// Every line of the log goes to the recording, too.
class RecordingSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit RecordingSink(SenseRecording* recording) : recording_(*recording) {}

 protected:
  void sink_it_(const spdlog::details::log_msg& line) override {
    constexpr int kDebug = static_cast<int>(spdlog::level::debug);
    recording_.Log(std::max(0, static_cast<int>(line.level) - kDebug),
                   {line.payload.data(), line.payload.size()});
  }
  void flush_() override {}

 private:
  SenseRecording& recording_;
};

Recording::Options FileOptions(const ServeOptions& options, const Scene& scene) {
  RequireOtherThan("--record", options.record, InputFilesOf(scene));
  Recording::Options file;
  file.file = options.record;
  file.limit = ParseRecordLimit(options.record_limit);
  file.part = options.record_part;
  file.tell = [](const std::string& why) { spdlog::warn("{}", why); };
  return file;
}

// While a slave serves, its sensing and its log are written to the file. Ends with a line in the
// log.
class SlaveRecorder {
 public:
  // Throws std::invalid_argument or std::runtime_error: the options, the file cannot be written.
  SlaveRecorder(const ServeOptions& options, const Scene& scene)
      : file_(options.record),
        recording_(scene, options.overrides, FileOptions(options, scene)),
        sink_(std::make_shared<RecordingSink>(&recording_)) {
    spdlog::default_logger()->sinks().push_back(sink_);
    spdlog::info("recording to {}, size limit {}", file_.string(), options.record_limit);
  }
  ~SlaveRecorder() {
    std::erase(spdlog::default_logger()->sinks(), sink_);
    recording_.Finish();
    const Recording::Stats stats = recording_.stats();
    spdlog::info("recorded {:.1f} MB in {} messages to {}", 1e-6 * static_cast<double>(stats.bytes),
                 stats.messages, file_.string());
    if (!stats.trouble.empty()) spdlog::warn("{}", stats.trouble);
  }
  SlaveRecorder(const SlaveRecorder&) = delete;
  SlaveRecorder& operator=(const SlaveRecorder&) = delete;

  [[nodiscard]] SenseRecorder& sense() { return recording_; }

 private:
  const std::filesystem::path file_;
  SenseRecording recording_;
  std::shared_ptr<spdlog::sinks::sink> sink_;
};

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

// Throws std::invalid_argument: options that contradict each other.
void CheckSetup(const ServeOptions& options) {
  if (options.setup.empty() == options.scene.empty()) {
    throw std::invalid_argument("serve: expected SCENE, or --setup DIR without one");
  }
  const bool needs_scene =
      !options.record.empty() || !options.publish.empty() || !options.overrides.empty();
  if (!options.setup.empty() && needs_scene) {
    throw std::invalid_argument("--setup: expected no --record, --publish or --override");
  }
}

// The slave that is served, with what it needs.
struct Served {
  std::optional<SlaveRecorder> recording;
  std::unique_ptr<Slave> live;          // of a scene
  std::unique_ptr<SetupSession> setup;  // without one

  [[nodiscard]] Slave& slave() { return setup ? setup->slave() : *live; }
};

void OpenScene(const ServeOptions& options, const std::stop_token& stop, Served* served) {
  const Scene scene = LoadRunningScene(options.scene, options.overrides, SceneUse::kFull, stop);
  if (!options.record.empty()) served->recording.emplace(options, scene);
  SenseRecorder* recorder = served->recording ? &served->recording->sense() : nullptr;
  served->live = MakeLiveSlave(scene, options.state_dir, recorder, ChosenAgain);
  const SlaveDescription description = served->live->Describe();
  Introduce(description);
  const std::string missing = MissingGuards(scene.manipulator);
  if (description.sense.tells_force && !missing.empty()) spdlog::warn("{}", missing);
}

void OpenSetup(const ServeOptions& options, Served* served) {
  served->setup =
      std::make_unique<SetupSession>(SetupOptions{options.setup, options.state_dir, ChosenAgain},
                                     NamedCamera(options.camera, options.camera_rate));
  spdlog::info("set-up with {}: a scene is saved in {}",
               served->setup->slave().Describe().sense.source, options.setup.string());
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
  CheckSetup(options);
  const bool plain = options.tls.empty();
  RequireLoopbackUnless(options.insecure || !plain, ParseEndpoint(options.listen));
  if (!options.metrics.empty()) MetricsEndpoint(options.metrics, options.insecure);
  std::optional<NatsServer> nats;
  if (!options.publish.empty())
    nats = ParseNatsServer(options.publish, options.insecure, options.tls);
  if (plain && !IsLoopback(ParseEndpoint(options.listen).host)) {
    spdlog::warn(
        "--insecure: {} serves every client in plain text: anyone who can reach it can move the "
        "tool",
        options.listen);
  }
  Served served;
  if (options.setup.empty()) {
    OpenScene(options, stop, &served);
  } else {
    OpenSetup(options, &served);
  }
  Slave& slave = served.slave();
  Server server(slave, options.listen, options.insecure, options.tls);
  std::optional<MetricsPage> metrics;
  if (!options.metrics.empty())
    metrics.emplace(options.metrics, options.insecure, [&] { return MetricsOf(slave, server); });
  if (metrics) spdlog::info("metrics at http://{}/metrics", ToString(metrics->endpoint()));
  malloc_trim(0);  // what only the start needed
  fmt::print("listening on {}\n", server.address());
  std::fflush(stdout);
  signals.OnEmergency([&slave] { slave.EmergencyStop("by SIGUSR1"); });
  if (nats) server.PublishOn(*nats);
  WaitFor(stop);
  signals.OnEmergency(nullptr);
  spdlog::info("stopping");
  server.Stop();
  return 0;
}

}  // namespace palpate
