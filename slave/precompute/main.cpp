// palpate-precompute: the command line.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <malloc.h>
#include <sys/resource.h>

#include "shared/program/program.h"
#include "shared/text/text.h"
#include "slave/commands/command_program.h"
#include "slave/commands/program.h"
#include "slave/commands/progress_bar.h"
#include "slave/precompute/precompute.h"
#include "slave/scene/scene_loader.h"

namespace palpate {
namespace {

constexpr const char* kExamples = R"(Examples:
  mpirun -n 4 palpate-precompute block.yaml
  mpirun -n 4 palpate-precompute block.yaml --override 'object.geometry.box.cells=[40, 40, 40]' --out build/cache

Exit codes: 0 done, 1 ran and failed, 2 unusable arguments or scene.)";

struct Options {
  std::filesystem::path scene, out;
  std::vector<std::string> overrides;
};

Scene Load(const Options& options) {
  Scene scene = LoadScene(options.scene, options.overrides, SceneUse::kSolve);
  if (!options.out.empty()) scene.model.cache = options.out;
  if (scene.model.kind != "fem-green" && scene.model.kind != "bem3d") {
    throw std::invalid_argument("model.kind = " + scene.model.kind +
                                ": accepted is fem-green or bem3d");
  }
  if (scene.model.cache.empty()) {
    throw std::invalid_argument("no cache: accepted is a folder, as model.cache or as --out");
  }
  return scene;
}

double PeakMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024e-6;
}

int Run(const Options& options, const Ranks& ranks, const std::stop_token& stop) {
  Scene scene;
  ranks.Together([&] { scene = Load(options); });
  std::optional<ProgressBar> bar;
  if (ranks.first()) bar.emplace("precompute", stop);
  Progress* progress = bar ? &*bar : nullptr;
  const std::string report = scene.model.kind == "bem3d"
                                 ? PrecomputeBem3d(scene, ranks, progress)
                                 : PrecomputeFemGreen(scene, ranks, progress);
  const std::vector<double> peaks = ranks.Gather(PeakMegabytes());
  if (!ranks.first()) return 0;
  bar->Clear();
  std::printf("%s\ncache: %s\nranks: %d, peak memory of one at most %.0f MB\n", report.c_str(),
              scene.model.cache.c_str(), ranks.size(), *std::ranges::max_element(peaks));
  return 0;
}

int Guarded(const Options& options, const Ranks& ranks, const std::stop_token& stop) {
  const auto say = [](const std::string& what) {
    std::fprintf(stderr, "palpate-precompute: %s\n", what.c_str());
  };
  try {
    return Run(options, ranks, stop);
  } catch (const RanksError& error) {
    if (ranks.first()) say(error.what());
    return error.exit_code();
  } catch (const Interrupted& error) {
    if (ranks.first()) say(std::string(error.what()) + ": what is finished is in the cache");
    return kFailed;
  } catch (const std::exception& error) {  // others may wait for this rank
    say("rank " + std::to_string(ranks.rank()) + ": " + error.what());
    EndAllRanks(kFailed);
  }
}

int Main(int argc, char** argv) {
  // Memory is what ranks are added for: what large arrays had goes back to the system at once.
  constexpr int kLarge = 1 << 20;  // [bytes]
  mallopt(M_MMAP_THRESHOLD, kLarge);
  LogToStderr();
  StopOnSignal stop;
  stop.ExpectAnswer();
  CLI::App app{
      "Computes the Green's functions of large fem-green and bem3d models with MPI, and writes the "
      "cache that the slave reads (model.cache).",
      "palpate-precompute"};
  app.footer(kExamples);
  app.set_version_flag("--version", Version());
  Options options;
  AddSceneOptions(&app, &options.scene, &options.overrides);
  Add(&app, "--out", &options.out, "DIR",
      "Folder of the cache; without it model.cache of the scene");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    const Ranks ranks;
    if (ranks.first()) app.exit(error);
    return kUnusable;
  }
  const Ranks ranks;
  return Guarded(options, ranks, stop.token());
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::Main(argc, argv);
}
