#include "slave/commands/study/study_command.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "shared/text/text.h"
#include "slave/commands/progress_bar.h"
#include "slave/commands/scene_remarks.h"
#include "slave/mechanics/factory/choose_model.h"
#include "slave/scene/scene_loader.h"
#include "slave/study/own_model.h"
#include "slave/study/reachable_places.h"
#include "slave/study/report.h"
#include "slave/study/study.h"

namespace palpate {
namespace {

// Runs the study. Its result files are rewritten after every model.
study::StudyResult RunWhole(const Scene& scene, const study::StudySettings& settings,
                            const std::filesystem::path& folder, const std::stop_token& stop) {
  ProgressBar bar("study", stop);
  const auto write = [&](const study::StudyResult& so_far) { study::WriteStudy(so_far, folder); };
  return study::RunStudy(scene, settings, study::DefaultModelFactory(), stop, {write, &bar});
}

}  // namespace

int RunStudyCommand(const StudyOptions& options, const std::stop_token& stop) {
  if (options.out.empty()) throw std::invalid_argument("--out is required: expected a folder");
  const Scene scene = LoadScene(options.scene, options.overrides, SceneUse::kSolve);
  LogRemarks(scene);
  if (!(options.budget > 0)) {
    throw std::invalid_argument("--budget " + std::to_string(options.budget) +
                                ": expected a number of seconds > 0");
  }
  RequireOtherThan("--out", options.out, {"study.csv", "study.json"}, InputFilesOf(scene));
  study::StudySettings settings;
  if (scene.model.kind == "auto" && study::CanStudy(scene)) {
    settings.places = study::PlacesToStudy(scene);  // nobody named a model for one contact
  }
  settings.budget_s = options.budget;
  std::filesystem::create_directories(options.out);
  const study::StudyResult study = RunWhole(WithChosenModel(scene), settings, options.out, stop);
  std::fputs(study::ToTable(study).c_str(), stdout);
  const bool any = std::ranges::any_of(study.rows, [](const study::StudyRow& row) {
    return row.outcome == study::Outcome::kAnswered;
  });
  return any ? 0 : 1;
}

}  // namespace palpate
