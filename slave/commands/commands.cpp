#include "slave/commands/commands.h"

#include <algorithm>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <malloc.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "shared/link/loopback.h"
#include "shared/metrics/metrics_page.h"
#include "shared/program/program.h"
#include "shared/text/text.h"
#include "slave/commands/program.h"
#include "slave/commands/progress_bar.h"
#include "slave/commands/record/record.h"
#include "slave/commands/running_scene.h"
#include "slave/pipeline/offline/end_to_end.h"
#include "slave/pipeline/offline/offline_run.h"
#include "slave/pipeline/teleop/live_slave.h"
#include "slave/scene/scene_loader.h"
#include "slave/service/server.h"
#include "slave/service/slave_metrics.h"
#include "slave/study/auto_model.h"
#include "slave/study/report.h"
#include "slave/study/study.h"

namespace palpate {
namespace {

void PrintStage(const StageTimes& s) {
  fmt::print("  {:<10} {:>9.1f} {:>9.1f} {:>9.1f}\n", s.stage, s.p50_us, s.p99_us, s.max_us);
}

void PrintPace(const OfflineSummary& s) {
  fmt::print("{} {} in {:.2f} s: {:.0f} {}/s\n", s.frames, s.sense.samples, s.seconds, s.rate(),
             s.sense.samples);
  fmt::print("  {:<10} {:>9} {:>9} {:>9}\n", "step [us]", "median", "99 %", "largest");
  PrintStage(TimesOf("capture", s.capture));
  for (const StageTimes& stage : s.stages) PrintStage(stage);
}

void PrintBudget(const ErrorBudget& budget, const std::string& what) {
  if (budget.count == 0) return;
  const double peak = budget.peak_force;
  fmt::print(
      "force error over {} {} in contact, true peak {:.4g} N: rms {:.3g} N ({:.2f} % of the peak), "
      "largest {:.3g} N; due to the model {:.2f} %, due to tracking {:.2f} %\n",
      budget.count, what, peak, budget.rms, 100 * budget.rms / peak, budget.peak_error,
      100 * budget.model_rms / peak, 100 * budget.tracking_rms / peak);
}

void Print(const OfflineSummary& s, const std::filesystem::path& out) {
  for (const std::string& line : Introduction(s.sense)) fmt::print("{}\n", line);
  PrintPace(s);
  fmt::print("validity:");
  for (const auto& [name, count] : s.validity) fmt::print(" {} {}", name, count);
  fmt::print("\n");
  PrintBudget(s.budget, s.sense.samples);
  for (const std::string& line : s.lines) fmt::print("{}\n", line);
  fmt::print("written: {}, {}\n", (out / "states.csv").string(), (out / "summary.json").string());
}

// The keys that make a recording of the frames just written.
void PrintFrames(const Scene& scene, const std::filesystem::path& out) {
  if (!scene.sense.Find<StereoCameras>()) return;
  const auto folder = std::filesystem::absolute(out / "frames");
  fmt::print(
      "to process them again:\n  sense.camera={{stereo: {{left: \"{0}/left/*.png\", right: "
      "\"{0}/right/*.png\", rig: \"{0}/rig.yaml\"}}, rate: {1:g} Hz, {2}}}\n",
      folder.string(), scene.sense.Find<StereoCameras>()->rate,
      ScenePose(scene.sense.Find<StereoCameras>()->X_SL));
}

void RefusePictures(const ProcessOptions& options, const Scene& scene) {
  if (!options.pictures && !options.frames) return;
  throw std::invalid_argument(std::string(options.pictures ? "--pictures" : "--frames") + ": " +
                              scene.file.string() + " has no camera");
}

// Of --duration; 0: not asked for.
double Duration(const ProcessOptions& options, const Scene& scene) {
  constexpr double kLongest = 86400;  // [s]
  if (!options.duration) return 0;
  const double duration = *options.duration;
  if (!(duration > 0 && duration <= kLongest)) {
    throw std::invalid_argument(
        fmt::format("--duration = {:g}: accepted is 0 < seconds <= {:g}", duration, kLongest));
  }
  if (!HasStereoOrDepth(scene.sense)) {
    throw std::invalid_argument(
        fmt::format("--duration: accepted for a simulated target that moves on a path; {} has none",
                    scene.file.string()));
  }
  return duration;
}

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

int RunProcess(const ProcessOptions& options, const std::stop_token& stop) {
  if (IsRecording(options.scene)) return RunProcessRecording(options, stop);
  const Scene scene = LoadRunningScene(options.scene, options.overrides, SceneUse::kFull, stop);
  const auto inputs = InputFilesOf(scene);
  RequireOtherThan("--out", options.out, {"states.csv", "summary.json"}, inputs);
  if (options.pictures) RequireOtherThan("--pictures", options.out, {"pictures"}, inputs);
  if (options.frames) {
    RequireOtherThan("--frames", options.out,
                     {"frames", "frames/left", "frames/right", "frames/rig.yaml"}, inputs);
  }
  if (options.points) RequireOtherThan("--points", options.out, {"points.csv"}, inputs);
  const double duration = Duration(options, scene);
  if (!HasPictures(scene.sense)) RefusePictures(options, scene);
  const bool terminal = isatty(STDERR_FILENO) != 0;
  const auto progress = [&](std::uint64_t done) {
    if (terminal && done % 50 == 0) fmt::print(stderr, "\r{}", done);
  };
  const OfflineSummary summary = RunOffline(
      scene, {options.out, options.pictures, options.frames, progress, duration, options.points},
      stop);
  if (terminal) fmt::print(stderr, "\r                    \r");
  Print(summary, options.out);
  if (options.frames) PrintFrames(scene, options.out);
  return 0;
}

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

int RunEndToEnd(const StudyOptions& options, const std::stop_token& stop) {
  const Scene scene = LoadRunningScene(options.scene, options.overrides, SceneUse::kFull, stop);
  RequireOtherThan("--out", options.out, {"end_to_end.json", "end_to_end.svg"},
                   InputFilesOf(scene));
  std::filesystem::create_directories(options.out);
  const EndToEndBudget budget = MeasureEndToEnd(scene, options.delay, stop);
  WriteBudget(budget, options.out);
  std::fputs(ToTable(budget).c_str(), stdout);
  return budget.total > 0 ? 0 : 1;
}

int RunStudyCommand(const StudyOptions& options, std::stop_token stop) {
  if (options.end_to_end) return RunEndToEnd(options, stop);
  const Scene scene = LoadScene(options.scene, options.overrides, SceneUse::kSolve);
  if (!(options.budget > 0)) {
    throw std::invalid_argument("--budget " + std::to_string(options.budget) +
                                ": accepted is a number of seconds > 0");
  }
  RequireOtherThan("--out", options.out, {"study.csv", "study.json", "study.svg"},
                   InputFilesOf(scene));
  std::filesystem::create_directories(options.out);
  study::StudySettings settings;
  if (scene.model.kind == "auto" && study::CanStudy(scene)) {
    settings.places = study::PlacesToDecide(scene);  // what it finds is kept for `auto`
  }
  settings.budget_s = options.budget;
  study::StudyResult result;
  {
    ProgressBar bar("study", stop);
    study::StudyWatcher watcher{
        [&](const study::StudyResult& so_far) { study::WriteStudy(so_far, options.out); }, &bar};
    result = study::RunStudy(scene, settings, study::RealWorkshop(), stop, watcher);
  }
  std::fputs(study::ToTable(result).c_str(), stdout);
  KeepDecision(result, scene, options.overrides);
  const bool any = std::ranges::any_of(result.rows, [](const study::StudyRow& row) {
    return row.outcome == study::Outcome::kAnswered;
  });
  return any ? 0 : 1;
}

}  // namespace palpate
