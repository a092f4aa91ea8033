#include "slave/study/quick_choice.h"

#include <algorithm>

#include "slave/study/pareto.h"

namespace palpate::study {

std::optional<QuickChoice> ChooseQuickly(const Scene& scene, const ModelFactory& workshop,
                                         double budget_s) {
  StudySettings settings;
  settings.budget_s = budget_s;
  settings.timing_s = 0.01 * budget_s;
  settings.limits = {.dof = 40'000, .dense_dof = 1200, .residuals = false, .families = {}};
  StudyResult study = RunStudy(scene, settings, workshop);
  std::erase_if(study.rows, [](const StudyRow& row) { return !row.own; });
  const std::string reason = Recommend(scene.model.tolerance, scene.model.rate, &study.rows);
  const auto choice = std::ranges::find_if(study.rows, &StudyRow::recommended);
  if (choice == study.rows.end()) return std::nullopt;
  return QuickChoice{choice->model, reason, choice->meets_tolerance && choice->meets_rate};
}

}  // namespace palpate::study
