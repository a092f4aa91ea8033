#include "slave/commands/serve/serve.h"

#include <algorithm>
#include <chrono>
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
#include "shared/nats/nats_connection.h"
#include "shared/program/program.h"
#include "shared/text/text.h"
#include "slave/commands/program.h"
#include "slave/commands/scene_remarks.h"
#include "slave/commands/scene_summary.h"
#include "slave/commands/serve/setup_session.h"
#include "slave/live/live_slave.h"
#include "slave/recording/sense_recording.h"
#include "slave/service/server.h"

namespace palpate {
namespace {

// Longest time for the answer of UseScene, and for others, to reach their clients.
constexpr std::chrono::seconds kAnswers(3);

// Also writes every line of the log to the recording.
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

// Writes the sensing and the log of a slave to the file while it serves. Ends with a line in the
// log.
class SlaveRecorder {
 public:
  // Throws std::invalid_argument for unusable options and std::runtime_error if the file cannot be
  // written.
  SlaveRecorder(const ServeOptions& options, const Scene& scene)
      : recording_(scene, options.overrides, FileOptions(options, scene)),
        sink_(std::make_shared<RecordingSink>(&recording_)) {
    spdlog::default_logger()->sinks().push_back(sink_);
    spdlog::info("recording to {}, size limit {}", recording_.file().string(),
                 options.record_limit);
  }
  ~SlaveRecorder() {
    std::erase(spdlog::default_logger()->sinks(), sink_);
    recording_.Finish();
    const Recording::Stats stats = recording_.stats();
    spdlog::info("recorded {:.1f} MB in {} messages to {}", 1e-6 * static_cast<double>(stats.bytes),
                 stats.messages, recording_.file().string());
    if (!stats.trouble.empty()) spdlog::warn("{}", stats.trouble);
  }
  SlaveRecorder(const SlaveRecorder&) = delete;
  SlaveRecorder& operator=(const SlaveRecorder&) = delete;

  [[nodiscard]] SenseRecorder& sense() { return recording_; }

 private:
  SenseRecording recording_;
  std::shared_ptr<spdlog::sinks::sink> sink_;
};

void Introduce(const SlaveDescription& d) {
  spdlog::info("{}", d.scene.name);
  try {
    spdlog::info("{}", SceneSummary(d.scene));
    // The object is only known from the cameras, or no model supports it.
  } catch (const std::exception&) {
  }
  for (const std::string& line : Introduction(d.sense)) spdlog::info("{}", line);
}

void WaitFor(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any changed;
  std::unique_lock lock(mutex);
  changed.wait(lock, stop, [] { return false; });
}

// Throws std::invalid_argument if options contradict each other.
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

std::unique_ptr<LiveSlave> OpenScene(const ServeOptions& options,
                                     std::optional<SlaveRecorder>* recording) {
  const Scene scene = LoadRunningScene(options.scene, options.overrides);
  if (!options.record.empty()) recording->emplace(options, scene);
  SenseRecorder* recorder = *recording ? &(*recording)->sense() : nullptr;
  auto slave = MakeLiveSlave(scene, options.state_dir, recorder);
  const SlaveDescription description = slave->Describe();
  Introduce(description);
  const std::string missing = MissingGuards(scene.manipulator);
  if (description.sense.has_force_estimate && !missing.empty()) spdlog::warn("{}", missing);
  return slave;
}

std::unique_ptr<LiveSlave> OpenSetup(const ServeOptions& options,
                                     std::optional<SetupSession>* setup) {
  setup->emplace(options.setup, NamedCamera(options.camera, options.camera_rate));
  auto slave = (*setup)->First();
  if (!options.state_dir.empty()) slave->KeepStopIn(options.state_dir);
  const SlaveDescription description = slave->Describe();
  if (!description.scene.name.empty()) Introduce(description);
  spdlog::info("set-up with {}: scenes are saved in {}", description.sense.source,
               options.setup.string());
  return slave;
}

// Replaces `former`, which is no longer served and ends here, by `next`, which continues with
// greater revisions of the settings and with its emergency stop.
void TakePlace(std::unique_ptr<LiveSlave> former, const std::filesystem::path& state_dir,
               LiveSlave* next) {
  next->ContinueRevisions(former->Describe().settings_revision);
  const bool is_stopped = former->Status().phase == Phase::kEstop;
  former.reset();  // only one slave at a time may keep its stop record in the folder
  try {
    if (!state_dir.empty()) next->KeepStopIn(state_dir);
  } catch (const std::exception& error) {
    spdlog::error("an emergency stop may end with this process: {}", error.what());
  }
  if (is_stopped && next->Status().phase != Phase::kEstop) {
    next->EmergencyStop("before the new scene");
  }
  Introduce(next->Describe());
}

}  // namespace

int RunServe(const ServeOptions& options, StopOnSignal& signals) {
  const std::stop_token stop = signals.token();
  // Limits the number of arenas: each of eight per processor would retain a few unused images.
  mallopt(M_ARENA_MAX, 4);
  CheckSetup(options);
  const bool plain = options.tls.empty();
  RequireLoopbackUnless(options.insecure || !plain, ParseEndpoint(options.listen));
  std::optional<NatsServer> nats;
  if (!options.publish.empty())
    nats = ParseNatsServer(options.publish, options.insecure, options.tls);
  if (plain && !IsLoopback(ParseEndpoint(options.listen).host)) {
    spdlog::warn(
        "--insecure: {} serves every client in plain text: anyone who can reach it can move the "
        "tool",
        options.listen);
  }
  std::optional<SlaveRecorder> recording;
  std::optional<SetupSession> setup;
  std::unique_ptr<LiveSlave> slave =
      options.setup.empty() ? OpenScene(options, &recording) : OpenSetup(options, &setup);
  std::string listen = options.listen;
  for (bool is_first = true;; is_first = false) {
    std::optional<Server> server(std::in_place, *slave, listen, options.insecure, options.tls);
    malloc_trim(0);  // frees memory that only the start needed
    // After another scene the port is the same, and clients connect to it again.
    listen = server->address();
    if (is_first) fmt::print("listening on {}\n", listen);
    std::fflush(stdout);
    signals.OnEmergency([&slave] { slave->EmergencyStop("by SIGUSR1"); });
    if (nats) server->PublishOn(*nats);
    std::unique_ptr<LiveSlave> next;
    if (setup) {
      next = setup->Next(stop);
    } else {
      WaitFor(stop);
    }
    signals.OnEmergency(nullptr);
    if (next == nullptr) {
      spdlog::info("stopping");
      server->Stop();
      return 0;
    }
    server->Stop(kAnswers);
    server.reset();
    TakePlace(std::exchange(slave, nullptr), options.state_dir, next.get());
    slave = std::move(next);
  }
}

}  // namespace palpate
