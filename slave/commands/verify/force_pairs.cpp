#include "slave/commands/verify/force_pairs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "shared/text/csv.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Names = std::array<std::string, 3>;

constexpr double kLargest = 1e12;

Names AxisColumns(const std::string& option, const std::string& names) {
  std::vector<std::string> parts{""};
  for (const char c : names) {
    if (c == ',') parts.emplace_back();
    if (c != ',') parts.back() += c;
  }
  if (parts.size() == 1) return {"-", "-", parts[0]};
  if (parts.size() != 3) {
    throw std::invalid_argument(option + " = " + names +
                                ": expected one column, or three with commas between them");
  }
  return {parts[0], parts[1], parts[2]};
}

double FactorOf(const std::string& option, const std::string& unit, Quantity quantity) {
  const auto found = FindUnit(unit == "g" ? "gf" : unit);
  if (!found || found->quantity != quantity) {
    throw std::invalid_argument(
        option + " = " + unit + ": expected " +
        (quantity == Quantity::kTime ? "s, ms, min or h" : "N, mN, uN, kN, g, kgf or lbf"));
  }
  return found->to_si;
}

// A column's numbers in SI.
class PairColumn {
 public:
  PairColumn(const CsvTable& table, const std::string& name, double factor)
      : column_(table.Find(name)), factor_(factor) {}
  [[nodiscard]] bool is_present() const { return column_.has_value(); }
  // NaN: the column is absent, or its cell is empty.
  [[nodiscard]] double Value(const CsvTable& table) const {
    if (!column_ || Trimmed(table.Text(*column_)).empty()) return kUnknown;
    const bool has_unit = table.to_si(*column_) != 1;
    return table.Number(*column_, kLargest) * (has_unit ? 1 : factor_);
  }

 private:
  std::optional<std::size_t> column_;
  double factor_;
};

using ForceColumn = std::array<PairColumn, 3>;

ForceColumn ColumnsOf(const CsvTable& table, const Names& names, double factor) {
  return {PairColumn(table, names[0], factor), PairColumn(table, names[1], factor),
          PairColumn(table, names[2], factor)};
}

Vector3d VectorOf(const CsvTable& table, const ForceColumn& columns) {
  return {columns[0].Value(table), columns[1].Value(table), columns[2].Value(table)};
}

bool IsValid(const std::string& word) {
  constexpr std::array kWords{"valid", "1", "true", "True"};
  return std::ranges::find(kWords, word) != kWords.end();
}

// A name that the user gave must be in the table.
void RequireGiven(const CsvTable& table, const std::string& name, const std::string& usual) {
  if (name != usual && name != "-" && !table.Has(name)) table.Fail("no column " + name, 1);
}

}  // namespace

std::vector<MatchedState> ReadForcePairs(const std::filesystem::path& file,
                                         const ForceColumns& columns) {
  const double of_known = FactorOf("--measured-unit", columns.measured_unit, Quantity::kForce);
  const double of_estimate = FactorOf("--estimated-unit", columns.estimated_unit, Quantity::kForce);
  const double of_time = FactorOf("--time-unit", columns.time_unit, Quantity::kTime);
  const Names known = AxisColumns("--measured", columns.measured);
  const Names estimate = AxisColumns("--estimated", columns.estimated);
  CsvTable table(file);
  const ForceColumns usual;
  if (columns.measured != usual.measured) {
    for (const std::string& name : known) RequireGiven(table, name, "-");
  }
  if (columns.estimated != usual.estimated) {
    for (const std::string& name : estimate) RequireGiven(table, name, "-");
  }
  RequireGiven(table, columns.time, usual.time);
  RequireGiven(table, columns.sigma, usual.sigma);
  RequireGiven(table, columns.validity, usual.validity);
  const ForceColumn measured = ColumnsOf(table, known, of_known);
  const ForceColumn estimated = ColumnsOf(table, estimate, of_estimate);
  std::array<bool, 3> is_compared{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    is_compared[axis] = measured[axis].is_present() && estimated[axis].is_present();
  }
  if (std::ranges::none_of(is_compared, [](bool is) { return is; })) {
    table.Fail("no axis has a measured and an estimated force: expected columns " +
                   columns.measured + " and " + columns.estimated +
                   ", or other names by --measured and --estimated",
               1);
  }
  const PairColumn time(table, columns.time, of_time);
  const PairColumn sigma(table, columns.sigma, of_estimate);
  std::vector<MatchedState> pairs;
  while (table.Next()) {
    MatchedState pair;
    pair.state.t = time.Value(table);
    pair.state.force = VectorOf(table, estimated);
    pair.state.sigma = sigma.is_present() ? sigma.Value(table) : 0;
    if (pair.state.sigma < 0) table.Fail(columns.sigma + ": expected 0 or more");
    pair.state.is_valid = table.IsAbsent(columns.validity) || IsValid(table.Text(columns.validity));
    pair.known.force = VectorOf(table, measured);
    bool is_whole = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<Eigen::Index>(axis);
      if (!is_compared[axis]) pair.known.force(at) = pair.state.force(at) = kUnknown;
      if (is_compared[axis] && !std::isfinite(pair.known.force(at) + pair.state.force(at))) {
        is_whole = false;
      }
    }
    if (is_whole && std::isfinite(pair.state.sigma)) pairs.push_back(pair);
  }
  if (std::ranges::all_of(pairs, [](const auto& pair) { return std::isfinite(pair.state.t); })) {
    std::ranges::stable_sort(pairs, {}, [](const auto& pair) { return pair.state.t; });
  }
  return pairs;
}

}  // namespace palpate
