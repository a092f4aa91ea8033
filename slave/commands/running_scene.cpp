#include "slave/commands/running_scene.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <span>
#include <sstream>
#include <utility>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "shared/program/program.h"
#include "shared/text/text.h"
#include "slave/commands/progress_bar.h"
#include "slave/commands/scene_remarks.h"
#include "slave/mechanics/fem/green/column_cache.h"
#include "slave/scene/decided_model.h"
#include "slave/study/auto_model.h"

namespace palpate {
namespace {

// Empty if the file cannot be read.
std::string BytesOf(const std::filesystem::path& file) {
  std::ostringstream bytes;
  bytes << std::ifstream(file, std::ios::binary).rdbuf();
  return std::move(bytes).str();
}

// Returns the processor model of this machine, on which times depend.
std::string Processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line;
  }
  return {};
}

// File of the mesh or outline; empty: none.
std::filesystem::path ShapeFileOf(const Geometry& geometry) {
  if (const auto* mesh = std::get_if<MeshFileGeometry>(&geometry)) return mesh->file;
  if (const auto* contour = std::get_if<ContourFileGeometry>(&geometry)) return contour->file;
  return {};
}

// Returns the file of the decision, named by a hash of all its inputs; empty: decisions are not
// stored.
std::filesystem::path FileOf(const Scene& scene, const std::vector<std::string>& overrides,
                             SceneUse use) {
  const auto folder = CacheFolder();
  if (folder.empty()) return {};
  Hash hash;
  const auto add = [&](const std::string& text) {
    hash.Add(text.size()).Add(std::as_bytes(std::span(text)));
  };
  add(Version());
  add(Processor());
  add(BytesOf(scene.file));
  add(BytesOf(ShapeFileOf(scene.object.geometry)));
  for (const std::string& line : overrides) add(line);
  if (use == SceneUse::kSolve && !scene.sense.all().empty()) add("solve");
  return folder / Formatted("auto-%016llx.json", static_cast<unsigned long long>(hash.value()));
}

// If the folder cannot be written, nothing is stored and no error is reported.
void Keep(const Scene& decided, const std::filesystem::path& file) {
  if (file.empty()) return;
  std::error_code ignored;
  std::filesystem::create_directories(file.parent_path(), ignored);
  if (!TryReplace(file, DecidedText(decided), Links::kReplace)) {
    spdlog::info("auto: {} cannot be written: the next start chooses the model again",
                 file.string());
  }
}

// Without an estimated force there is no model.
bool EstimatesForce(const Scene& scene) {
  return !scene.sense.Find<Tactile>() || MeetsObject(scene);
}

void Decide(const std::filesystem::path& file, const std::stop_token& stop, Scene* scene) {
  if (!file.empty() && ApplyDecided(BytesOf(file), scene)) return;
  ProgressBar bar("auto", stop);
  auto decided = study::DecideOnThickness(*scene);
  if (!decided) {
    decided =
        study::DecideQuickly(*scene, study::DefaultModelFactory(), study::kQuickBudget, stop, &bar);
  }
  if (!decided) return;
  *scene = *std::move(decided);
  if (!stop.stop_requested()) Keep(*scene, file);
}

}  // namespace

std::filesystem::path CacheFolder() {
  const auto folder = [](const char* variable) {
    const char* value = std::getenv(variable);
    return std::filesystem::path(value == nullptr ? "" : value);
  };
  const auto cache = folder("XDG_CACHE_HOME"), home = folder("HOME");
  if (cache.is_absolute()) return cache / "palpate";
  return home.is_absolute() ? home / ".cache" / "palpate" : std::filesystem::path();
}

Scene LoadRunningScene(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                       SceneUse use, const std::stop_token& stop) {
  Scene scene = LoadScene(file, overrides, use);
  LogRemarks(scene);
  if (scene.model.kind != "auto" || !study::CanStudy(scene) || !EstimatesForce(scene)) return scene;
  // `solve` uses the model unchanged, a session as its sensing uses it.
  SenseOptions sense = scene.sense;
  if (use == SceneUse::kSolve) scene.sense = {};
  Decide(FileOf(scene, overrides, use), stop, &scene);
  scene.sense = std::move(sense);
  for (const std::string& line : LinesOf(scene.model.decision, 4)) spdlog::info("{}", line);
  return scene;
}

void KeepDecision(const study::StudyResult& study, const Scene& scene,
                  const std::vector<std::string>& overrides) {
  if (scene.model.kind != "auto") return;
  if (const auto decided = study::DecidedBy(study, scene))
    Keep(*decided, FileOf(scene, overrides, SceneUse::kFull));
}

std::string MissingGuards(const ManipulatorOptions& arm) {
  if (arm.source == ManipulatorOptions::Source::kNone) return {};
  const bool presses = std::isinf(arm.force_guard), sinks = std::isinf(arm.depth_guard);
  if (!presses && !sinks) return {};
  const char* keys = !sinks     ? "manipulator.force_guard is"
                     : !presses ? "manipulator.depth_guard is"
                                : "manipulator.force_guard and manipulator.depth_guard are";
  return fmt::format("{} not set: nothing limits the {} of an operator who engages again and again",
                     keys,
                     !sinks     ? "force"
                     : !presses ? "depth"
                                : "force and depth");
}

}  // namespace palpate
