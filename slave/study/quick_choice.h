// `model.kind: auto`: the cheapest model that meets the scene's tolerance and rate.
#pragma once

#include <optional>
#include <string>

#include "slave/study/study.h"

namespace palpate::study {

struct QuickChoice {
  ModelOptions model;  // the scene's, with kind, order, element and law decided; resolution is kept
  std::string reason;  // one sentence: what it is, its error, update time and precompute
  bool meets = false;  // tolerance and rate; else it is the nearest to them
};

// Studies the scene for at most about `budget_s` [s] and chooses among the models at the scene's
// own resolution; others serve as reference only. nullopt: none answered in time, so whoever asks
// takes the default of the geometry. Throws std::invalid_argument: see AskedOf.
std::optional<QuickChoice> ChooseQuickly(const Scene& scene, const ModelFactory& workshop,
                                         double budget_s = 1.5);

}  // namespace palpate::study
