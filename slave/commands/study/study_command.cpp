#include "slave/commands/study/study_command.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "shared/text/text.h"
#include "slave/commands/progress_bar.h"
#include "slave/commands/running_scene.h"
#include "slave/commands/study/end_to_end.h"
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

}  // namespace

int RunStudyCommand(const StudyOptions& options, const std::stop_token& stop) {
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
