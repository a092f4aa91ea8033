// What the suite found: a row per stage and case, as CSV that a later run goes on from, and as
// text.
#pragma once

#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "tests/campaigns/robustness/case.h"
#include "tests/campaigns/robustness/stage.h"
#include "tests/campaigns/robustness/trial.h"

namespace palpate::robustness {

struct Row {
  std::string sense, stage, name;  // `name`: the case's title
  Demand demand = Demand::kFlag;
  Score score;

  [[nodiscard]] std::string key() const { return stage + ": " + name; }
  [[nodiscard]] bool holds() const { return score.Holds(demand); }
};

// Appends to `file`, with a header where it is new. Throws std::runtime_error: not writable.
void Append(const Row& row, const std::filesystem::path& file);
// What Append wrote; empty: there is no such file. Throws InputError.
std::vector<Row> ReadRows(const std::filesystem::path& file);

// A line of the table as people read it, and the one above all.
std::string Headline();
std::string InWords(const Row& row);
// What it comes to: rows, those that hold, silent share by sense.
std::string Summary(std::span<const Row> rows);

// Keys, a line each, of rows that are known not to hold; `#` begins a comment. Empty path: none.
std::set<std::string> ReadKnown(const std::filesystem::path& file);

}  // namespace palpate::robustness
