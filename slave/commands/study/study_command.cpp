#include "slave/commands/study/study_command.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "shared/text/text.h"
#include "slave/commands/progress_bar.h"
#include "slave/commands/running_scene.h"
#include "slave/commands/scene_remarks.h"
#include "slave/commands/study/end_to_end.h"
#include "slave/commands/study/shards.h"
#include "slave/scene/scene_loader.h"
#include "slave/study/auto_model.h"
#include "slave/study/report.h"
#include "slave/study/study.h"

namespace palpate {
namespace {

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

// Rewritten after every model.
study::StudyResult RunWhole(const Scene& scene, const study::StudySettings& settings,
                            const std::filesystem::path& folder, const std::stop_token& stop) {
  ProgressBar bar("study", stop);
  const auto write = [&](const study::StudyResult& so_far) { study::WriteStudy(so_far, folder); };
  return study::RunStudy(scene, settings, study::RealWorkshop(), stop, {write, &bar});
}

}  // namespace

int RunStudyCommand(const StudyOptions& options, const std::stop_token& stop) {
  const auto& out = options.out.empty() ? options.merge : options.out;
  if (out.empty()) throw std::invalid_argument("--out is required: expected a folder");
  if (options.end_to_end) return RunEndToEnd(options, stop);
  study::StudySettings settings;
  if (!options.shard.empty()) settings.shard = ParseShard(options.shard);
  const Scene scene = LoadScene(options.scene, options.overrides, SceneUse::kSolve);
  LogRemarks(scene);
  if (!(options.budget > 0)) {
    throw std::invalid_argument("--budget " + std::to_string(options.budget) +
                                ": expected a number of seconds > 0");
  }
  RequireOtherThan("--out", out, {"study.csv", "study.json", "study.svg"}, InputFilesOf(scene));
  if (scene.model.kind == "auto" && study::CanStudy(scene)) {
    settings.places = study::PlacesToDecide(scene);  // what it finds is kept for `auto`
  }
  settings.budget_s = options.budget;
  MergedStudy done;
  if (!options.merge.empty()) {
    done = MergeShards(scene, options.overrides, settings, options.merge, stop);
  }
  std::filesystem::create_directories(out);
  if (settings.shard) return RunShard(scene, options.overrides, settings, out, stop);
  if (options.merge.empty()) {
    done.study = RunWhole(scene, settings, out, stop);
  } else {
    study::WriteStudy(done.study, out);
  }
  std::fputs(study::ToTable(done.study).c_str(), stdout);
  if (done.is_of_here) {
    KeepDecision(done.study, scene, options.overrides);
  } else {
    std::puts("note: shards ran on other processors than this one: their times may not compare");
  }
  const bool any = std::ranges::any_of(done.study.rows, [](const study::StudyRow& row) {
    return row.outcome == study::Outcome::kAnswered;
  });
  return any ? 0 : 1;
}

}  // namespace palpate
