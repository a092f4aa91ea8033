#include "slave/verify/force_table.h"

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

constexpr double kMaxValue = 1e12;  // in SI

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
        (quantity == Quantity::kTime ? "s, ms, us, ns, min or h" : "N, mN, uN, kN, g, kgf or lbf"));
  }
  return found->to_si;
}

// Reads the numbers of a column in SI units.
class NumberColumn {
 public:
  NumberColumn(const CsvTable& table, const std::string& name, double factor = 1)
      : column_(table.Find(name)), factor_(factor) {
    if (column_ && table.to_si(*column_) != 1) factor_ = 1;  // the title has a unit
  }
  [[nodiscard]] bool is_present() const { return column_.has_value(); }
  // NaN: the column is absent, or its cell is empty.
  [[nodiscard]] double Value(const CsvTable& table, const char* accepted) const {
    if (!column_ || Trimmed(table.Text(*column_)).empty()) return kUnknown;
    const double value = factor_ * table.Number(*column_);
    if (std::abs(value) > kMaxValue) table.Refuse(*column_, accepted);
    return value;
  }

 private:
  std::optional<std::size_t> column_;
  double factor_;
};

class VectorColumns {
 public:
  VectorColumns(const CsvTable& table, const Names& names, double factor = 1)
      : axes_{NumberColumn(table, names[0], factor), NumberColumn(table, names[1], factor),
              NumberColumn(table, names[2], factor)} {}
  [[nodiscard]] bool has(std::size_t axis) const { return axes_[axis].is_present(); }
  [[nodiscard]] Vector3d Value(const CsvTable& table) const {
    constexpr const char* kAccepted = "at most 1e12 in SI units";
    return {axes_[0].Value(table, kAccepted), axes_[1].Value(table, kAccepted),
            axes_[2].Value(table, kAccepted)};
  }

 private:
  std::array<NumberColumn, 3> axes_;
};

bool IsValid(const std::string& word) {
  constexpr std::array kWords{"valid", "1", "true", "True"};
  return std::ranges::find(kWords, word) != kWords.end();
}

// Requires that a column named by the user exists in the table.
void RequireGiven(const CsvTable& table, const std::string& names, const std::string& usual) {
  if (names == usual) return;
  for (const std::string& name : AxisColumns("", names)) {
    if (name == "-" || table.Has(name)) continue;
    std::string titles;
    for (const std::string& title : table.header()) titles += (titles.empty() ? "" : ", ") + title;
    table.Fail("no column " + name + ": there are " + titles, 1);
  }
}

// A message without a stamp has the time 0, while the others count from 1970.
void RequireSteady(const CsvTable& table, const std::string& column, double before, double t) {
  constexpr double kSince1970 = 1e8;  // [s]
  if (before != 0 || !(t > kSince1970)) return;
  table.Fail(
      Formatted("%s jumps from 0 to %.0f s: expected rows of one clock; leave out those "
                "without a stamp",
                column.c_str(), t));
}

}  // namespace

ForceTables ReadForces(const std::filesystem::path& file, const ForceColumns& columns) {
  const double of_measured = FactorOf("--measured-unit", columns.measured_unit, Quantity::kForce);
  const double of_estimate = FactorOf("--estimated-unit", columns.estimated_unit, Quantity::kForce);
  const double of_time = FactorOf("--time-unit", columns.time_unit, Quantity::kTime);
  const Names measured_names = AxisColumns("--measured", columns.measured);
  const Names estimated_names = AxisColumns("--estimated", columns.estimated);
  CsvTable table(file);
  const ForceColumns usual;
  RequireGiven(table, columns.measured, usual.measured);
  RequireGiven(table, columns.estimated, usual.estimated);
  RequireGiven(table, columns.time, usual.time);
  RequireGiven(table, columns.sigma, usual.sigma);
  RequireGiven(table, columns.validity, usual.validity);
  const VectorColumns measured(table, measured_names, of_measured);
  const VectorColumns estimated(table, estimated_names, of_estimate);
  bool is_compared = false;
  for (std::size_t i = 0; i < 3; ++i) is_compared |= measured.has(i) && estimated.has(i);
  if (!is_compared) {
    table.Fail("no axis has a measured and an estimated force: expected columns " +
                   columns.measured + " and " + columns.estimated +
                   ", or other names by --measured and --estimated",
               1);
  }
  const NumberColumn time(table, columns.time, of_time), hold(table, "hold");
  const NumberColumn sigma(table, columns.sigma, of_estimate);
  const NumberColumn depth(table, "depth"), known_depth(table, "known_depth");
  const VectorColumns known(table, {"known_x", "known_y", "known_z"});
  const VectorColumns tip(table, {"tip_x", "tip_y", "tip_z"});
  ForceTables tables;
  while (table.Next()) {
    ForceRow row;
    row.t = time.Value(table, "a time in the unit of --time-unit, up to 1e12 s (nanoseconds?)");
    const double number = hold.Value(table, "the number of a load");
    if (std::isfinite(number)) row.hold = static_cast<int>(std::clamp(number, 0.0, 1e9));
    row.measured = measured.Value(table);
    row.estimated = estimated.Value(table);
    row.sigma = sigma.Value(table, "a force");
    if (row.sigma < 0) table.Fail(columns.sigma + ": expected 0 or more");
    row.is_valid = table.IsAbsent(columns.validity) || IsValid(table.Text(columns.validity));
    row.p_known = known.Value(table);
    row.p_estimated = tip.Value(table);
    row.known_depth = known_depth.Value(table, "a length");
    row.depth = depth.Value(table, "a length");
    auto& rows = tables[table.IsAbsent("finger") ? "" : table.Text("finger")];
    if (!rows.empty() && row.t < rows.back().t) {
      table.Fail(
          Formatted("%s falls from %g to %g s: expected rows in order of time; judge joined "
                    "recordings one by one",
                    columns.time.c_str(), rows.back().t, row.t));
    }
    RequireSteady(table, columns.time, rows.empty() ? kUnknown : rows.back().t, row.t);
    rows.push_back(row);
  }
  if (tables.empty()) table.Fail("no row: expected one per instant", 1);
  return tables;
}

void WriteForces(const ForceTables& tables, const std::filesystem::path& file) {
  std::string text =
      "t,finger,hold,measured_fx,measured_fy,measured_fz,estimated_fx,estimated_fy,estimated_fz,"
      "sigma,known_x,known_y,known_z,tip_x,tip_y,tip_z,known_depth,depth,validity\n";
  const auto append = [&text](std::initializer_list<double> values) {
    for (const double value : values) {
      AppendNumber(&text, value, 17);
      text += ',';
    }
  };
  const auto append_vector = [&](const Vector3d& v) { append({v.x(), v.y(), v.z()}); };
  for (const auto& [finger, rows] : tables) {
    for (const ForceRow& row : rows) {
      append({row.t});
      text += finger + ',' + (row.hold < 0 ? "" : std::to_string(row.hold)) + ',';
      append_vector(row.measured);
      append_vector(row.estimated);
      append({row.sigma});
      append_vector(row.p_known);
      append_vector(row.p_estimated);
      append({row.known_depth, row.depth});
      text += row.is_valid ? "valid\n" : "flagged\n";
    }
  }
  WriteWholeFile(file, text);
}

}  // namespace palpate
