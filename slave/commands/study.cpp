#include "slave/commands/study.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "shared/text/text.h"
#include "slave/commands/progress_bar.h"
#include "slave/scene/scene_loader.h"
#include "slave/study/report.h"
#include "slave/study/study.h"

namespace palpate {

int RunStudyCommand(const StudyOptions& options, std::stop_token stop) {
  const Scene scene = LoadScene(options.scene, options.overrides, SceneUse::kSolve);
  if (!(options.budget > 0)) {
    throw std::invalid_argument("--budget " + std::to_string(options.budget) +
                                ": accepted is a number of seconds > 0");
  }
  RequireOtherThan("--out", options.out, {"study.csv", "study.json", "study.svg"},
                   InputFilesOf(scene));
  std::filesystem::create_directories(options.out);
  study::StudySettings settings;
  settings.budget_s = options.budget;
  study::StudyResult result;
  {
    ProgressBar bar("study", stop);
    study::StudyWatcher watcher{
        [&](const study::StudyResult& so_far) { study::WriteStudy(so_far, options.out); }, &bar};
    result = study::RunStudy(scene, settings, study::RealWorkshop(), stop, watcher);
  }
  std::fputs(study::ToTable(result).c_str(), stdout);
  const bool any = std::ranges::any_of(result.rows, [](const study::StudyRow& row) {
    return row.outcome == study::Outcome::kAnswered;
  });
  return any ? 0 : 1;
}

}  // namespace palpate
