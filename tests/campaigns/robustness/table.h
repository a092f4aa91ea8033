// The results of the suite, one row per stage and case: as CSV, from which a later run continues,
// and as text.
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
// Reads the rows that Append wrote. Empty: the file does not exist. Throws InputError.
std::vector<Row> ReadRows(const std::filesystem::path& file);

// A line of the table as people read it, and the one above all.
std::string Headline();
std::string InWords(const Row& row);
// Summarises: number of rows, number of rows that pass, and the share of undetected errors by
// sense.
std::string Summary(std::span<const Row> rows);

// Reads the keys of rows that are known to fail, one per line; `#` begins a comment. Empty path:
// none.
std::set<std::string> ReadKnown(const std::filesystem::path& file);

}  // namespace palpate::robustness
