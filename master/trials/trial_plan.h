// Trials of a user study: conditions from a table, in a random order that a seed repeats.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "master/haptics/render_mode.h"
#include "master/haptics/trial_label.h"

namespace palpate {

// The settings of a condition. Absent ones stay as they are, in every condition.
struct TrialCondition {
  std::string label;
  double seconds = 0;  // length of a trial [s]
  std::optional<RenderMode> render;
  std::optional<double> position_scale, force_scale, young_modulus;  // SI
  std::optional<std::string> model_kind;
};

struct Trial {
  TrialLabel label;
  TrialCondition condition;
};

// Reads a CSV table with one condition per row. Columns: `label` and `seconds`, and if wanted
// `repeats`, `render`, `operator.position_scale`, `operator.force_scale`,
// `object.material.young_modulus` and `model.kind`. A column has a value in every row, because an
// empty one would depend on the order. The order is a shuffle of all repeats (Fisher & Yates) by
// mt19937_64, which the standard defines, so that a seed gives the same order on every machine.
// Throws InputError `file:line: column = value: accepted is ...`.
std::vector<Trial> ReadTrials(const std::filesystem::path& file, std::uint64_t seed);

}  // namespace palpate
