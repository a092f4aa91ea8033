#include "master/trials/trial_plan.h"

#include <cmath>
#include <random>
#include <set>
#include <utility>

#include "shared/text/csv.h"

namespace palpate {
namespace {

constexpr double kMostRepeats = 1000, kLongestTrial = 86400;  // [-], [s]
constexpr std::size_t kMostTrials = 10000;

// Unbiased and the same on every machine, unlike std::uniform_int_distribution.
std::uint64_t Below(std::uint64_t count, std::mt19937_64* random) {
  const std::uint64_t usable = std::mt19937_64::max() - std::mt19937_64::max() % count;
  std::uint64_t drawn = (*random)();
  while (drawn >= usable) drawn = (*random)();
  return drawn % count;
}

std::optional<double> Positive(const CsvTable& table, std::string_view column) {
  if (!table.Has(column)) return std::nullopt;
  const double value = table.IsAbsent(column) ? 0 : table.Number(column);
  if (!(value > 0)) table.Refuse(column, "a number above 0");
  return value;
}

std::string LabelOf(const CsvTable& table) {
  std::string label = table.Text("label");
  bool is_good = label.size() <= TrialLabel::kLongest;
  for (const unsigned char c : label) is_good = is_good && c > ' ' && c < 127 && c != '"';
  if (!is_good) table.Refuse("label", "1 to 31 letters, digits and signs without blanks");
  return label;
}

TrialCondition ConditionOf(const CsvTable& table) {
  TrialCondition condition;
  condition.label = LabelOf(table);
  condition.seconds = table.Number("seconds");
  if (!(condition.seconds > 0 && condition.seconds <= kLongestTrial)) {
    table.Refuse("seconds", "above 0, at most 86400");
  }
  if (table.Has("render")) {
    condition.render = ParseRenderMode(table.Text("render"));
    if (!condition.render) table.Refuse("render", "local, interpolate or hold");
  }
  condition.position_scale = Positive(table, "operator.position_scale");
  condition.force_scale = Positive(table, "operator.force_scale");
  condition.young_modulus = Positive(table, "object.material.young_modulus");
  if (table.Has("model.kind")) condition.model_kind = table.Text("model.kind");
  return condition;
}

std::size_t RepeatsOf(const CsvTable& table) {
  if (!table.Has("repeats")) return 1;
  const double repeats = table.Number("repeats");
  if (!(repeats >= 1 && repeats <= kMostRepeats && repeats == std::floor(repeats))) {
    table.Refuse("repeats", "a whole number from 1 to 1000");
  }
  return static_cast<std::size_t>(repeats);
}

}  // namespace

std::vector<Trial> ReadTrials(const std::filesystem::path& file, std::uint64_t seed) {
  CsvTable table(file, {{"label"},
                        {"seconds"},
                        {"repeats", false},
                        {"render", false},
                        {"operator.position_scale", false},
                        {"operator.force_scale", false},
                        {"object.material.young_modulus", false},
                        {"model.kind", false}});
  std::vector<Trial> trials;
  std::set<std::string> labels;
  while (table.Next()) {
    const TrialCondition condition = ConditionOf(table);
    if (!labels.insert(condition.label).second) table.Refuse("label", "one row per label");
    trials.insert(trials.end(), RepeatsOf(table), {{}, condition});
    if (trials.size() > kMostTrials) table.Refuse("repeats", "at most 10000 trials in sum");
  }
  std::mt19937_64 random(seed);
  for (std::size_t i = trials.size(); i > 1; --i) {
    std::swap(trials[i - 1], trials[Below(i, &random)]);
  }
  std::uint32_t number = 0;
  for (Trial& trial : trials) trial.label = MakeTrialLabel(++number, trial.condition.label);
  return trials;
}

}  // namespace palpate
