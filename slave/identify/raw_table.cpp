#include "slave/identify/raw_table.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "shared/text/csv.h"
#include "shared/text/text.h"

namespace palpate::identify {
namespace {

struct Unit {
  std::string_view name;
  Quantity quantity;
  double to_si;
};
constexpr double kGravity = 9.80665;             // standard gravity [m/s^2]
constexpr double kInch = 0.0254;                 // [m]
constexpr double kPoundForce = 4.4482216152605;  // [N]
constexpr double kPsi = kPoundForce / (kInch * kInch);

// In small letters; see UnitOf for those whose first letter's size matters.
constexpr std::array kUnits{
    Unit{"pa", Quantity::kStress, 1},
    Unit{"kpa", Quantity::kStress, 1e3},
    Unit{"mpa", Quantity::kStress, 1e6},
    Unit{"gpa", Quantity::kStress, 1e9},
    Unit{"n/mm2", Quantity::kStress, 1e6},
    Unit{"n/mm^2", Quantity::kStress, 1e6},
    Unit{"n/cm2", Quantity::kStress, 1e4},
    Unit{"n/m2", Quantity::kStress, 1},
    Unit{"n/m^2", Quantity::kStress, 1},
    Unit{"kn/m2", Quantity::kStress, 1e3},
    Unit{"bar", Quantity::kStress, 1e5},
    Unit{"mbar", Quantity::kStress, 1e2},
    Unit{"psi", Quantity::kStress, kPsi},
    Unit{"ksi", Quantity::kStress, 1e3 * kPsi},
    Unit{"kgf/cm2", Quantity::kStress, 1e4 * kGravity},
    Unit{"kgf/mm2", Quantity::kStress, 1e6 * kGravity},
    Unit{"n", Quantity::kForce, 1},
    Unit{"mn", Quantity::kForce, 1e-3},
    Unit{"un", Quantity::kForce, 1e-6},
    Unit{"kn", Quantity::kForce, 1e3},
    Unit{"lbf", Quantity::kForce, kPoundForce},
    Unit{"kgf", Quantity::kForce, kGravity},
    Unit{"kp", Quantity::kForce, kGravity},
    Unit{"gf", Quantity::kForce, 1e-3 * kGravity},
    Unit{"m", Quantity::kLength, 1},
    Unit{"cm", Quantity::kLength, 1e-2},
    Unit{"mm", Quantity::kLength, 1e-3},
    Unit{"um", Quantity::kLength, 1e-6},
    Unit{"nm", Quantity::kLength, 1e-9},
    Unit{"in", Quantity::kLength, kInch},
    Unit{"inch", Quantity::kLength, kInch},
    Unit{"s", Quantity::kTime, 1},
    Unit{"sec", Quantity::kTime, 1},
    Unit{"ms", Quantity::kTime, 1e-3},
    Unit{"min", Quantity::kTime, 60},
    Unit{"h", Quantity::kTime, 3600},
    Unit{"%", Quantity::kNumber, 0.01},
    Unit{"percent", Quantity::kNumber, 0.01},
    Unit{"-", Quantity::kNumber, 1},
    Unit{"1", Quantity::kNumber, 1},
    Unit{"mm/mm", Quantity::kNumber, 1},
    Unit{"m/m", Quantity::kNumber, 1},
    Unit{"in/in", Quantity::kNumber, 1},
};

std::string Lower(std::string_view text) {
  std::string small(text);
  std::ranges::transform(small, small.begin(), [](unsigned char c) { return std::tolower(c); });
  return small;
}

// The micro sign and the Greek letter, in UTF-8 and in Latin-1, are written as u.
std::string WithPlainMicro(std::string_view text) {
  std::string plain(text);
  for (const std::string_view micro : {"\xC2\xB5", "\xCE\xBC", "\xB5"}) {
    for (std::size_t at; (at = plain.find(micro)) != std::string::npos;) {
      plain.replace(at, micro.size(), "u");
    }
  }
  return plain;
}

std::optional<Unit> UnitOf(std::string_view word) {
  const std::string plain = WithPlainMicro(Trimmed(word));
  if (plain == "mPa") return Unit{"mPa", Quantity::kStress, 1e-3};
  if (plain == "MN") return Unit{"MN", Quantity::kForce, 1e6};
  const auto* found = std::ranges::find(kUnits, Lower(plain), &Unit::name);
  if (found == kUnits.end()) return std::nullopt;
  return *found;
}

// Brackets hold units, but also words such as in `Strain (Extension) (%)`.
bool IsQualifier(std::string_view text) {
  constexpr std::array<std::string_view, 5> kShort{"true", "eng", "nom", "raw", "avg"};
  const bool letters = std::ranges::all_of(
      text, [](unsigned char c) { return std::isalpha(c) != 0 || c == ' ' || c >= 0x80; });
  return letters && (text.size() > 5 || std::ranges::count(kShort, Lower(text)) > 0);
}

void TakeUnit(const Unit& unit, RawColumn* column) {
  column->to_si = unit.to_si;
  column->quantity = unit.quantity;
  column->unknown_unit.clear();
}

// `Load (N)`, `Strain (Extension) (%)`, `Strain [-]`. Removes the brackets of units from the name.
void TakeBrackets(RawColumn* column) {
  std::size_t from = 0;
  for (;;) {
    const std::size_t open = column->name.find_first_of("([", from);
    if (open == std::string::npos) return;
    const std::size_t close =
        std::min(column->name.find_first_of(")]", open), column->name.size() - 1);
    const std::string inside(
        Trimmed(std::string_view(column->name).substr(open + 1, close - open - 1)));
    from = close + 1;
    if (const auto unit = UnitOf(inside)) {
      TakeUnit(*unit, column);
    } else if (IsQualifier(inside)) {
      continue;
    } else if (!column->to_si) {
      column->unknown_unit = inside;
    }
    column->name.erase(open, close - open + 1);
    from = open;
  }
}

// `Force / N`, `Stress, psi`, `P_MPa`, `Kraft in N`.
void TakeSuffix(RawColumn* column) {
  for (const std::string_view mark : {"/", ",", "_", " in "}) {
    const std::size_t at = column->name.rfind(mark);
    if (at == std::string::npos || at == 0) continue;
    const std::string suffix(Trimmed(std::string_view(column->name).substr(at + mark.size())));
    // `stretch_1` is the first, not one without unit.
    const auto unit = suffix == "1" ? std::nullopt : UnitOf(suffix);
    const bool needs_unit = mark == "/" || mark == ",";
    if (!unit && !needs_unit) continue;
    if (unit) {
      TakeUnit(*unit, column);
    } else {
      column->unknown_unit = suffix;
    }
    column->name.resize(at);
    return;
  }
}

RawColumn ColumnOf(std::string_view title) {
  RawColumn column{std::string(title), std::string(title), std::nullopt, std::nullopt, {}};
  TakeBrackets(&column);
  if (!column.to_si && column.unknown_unit.empty()) TakeSuffix(&column);
  std::string name = Lower(Trimmed(column.name));
  std::ranges::replace(name, '_', ' ');
  column.name = name;
  return column;
}

bool IsNumbers(const std::vector<std::string_view>& cells) {
  return std::ranges::all_of(cells, [](std::string_view c) { return ParseFinite(c).has_value(); });
}

bool HasWord(const std::vector<std::string_view>& cells) {
  return cells.size() >= 2 && !std::ranges::any_of(cells, [](std::string_view cell) {
           return ParseFinite(cell).has_value();
         });
}

// A comma at the end of a row is none too many.
std::vector<std::string_view> CellsOf(const CsvLines& lines) {
  std::vector<std::string_view> cells = lines.cells();
  if (cells.size() > 2 && cells.back().empty()) cells.pop_back();
  return cells;
}

void AddRow(const CsvLines& lines, RawTable* table) {
  const auto cells = CellsOf(lines);
  if (cells.size() != table->columns.size()) {
    lines.Fail(Formatted("%zu cells: accepted is %zu, the count of the header", cells.size(),
                         table->columns.size()));
  }
  std::vector<double> row;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto number = ParseFinite(cells[c]);
    if (!number) {
      lines.Fail(table->columns[c].title + " = " + Shown(cells[c]) +
                 ": accepted is a finite number");
    }
    row.push_back(*number);
  }
  table->rows.push_back(std::move(row));
  table->lines.push_back(lines.number());
}

}  // namespace

std::string InWords(Quantity quantity) {
  switch (quantity) {
    case Quantity::kNumber:
      return "a number without dimension (%, mm/mm or no unit)";
    case Quantity::kLength:
      return "a length in m cm mm um nm in";
    case Quantity::kForce:
      return "a force in N mN uN kN lbf kgf gf";
    case Quantity::kStress:
      return "a stress in Pa kPa MPa GPa N/mm2 N/cm2 bar psi ksi";
    case Quantity::kTime:
      return "a time in s ms min h";
  }
  return {};
}

std::optional<std::size_t> RawTable::Find(std::initializer_list<std::string_view> names) const {
  for (const std::string_view name : names) {
    const auto found = std::ranges::find(columns, name, &RawColumn::name);
    if (found != columns.end()) return static_cast<std::size_t>(found - columns.begin());
  }
  return std::nullopt;
}

std::size_t RawTable::Named(const std::string& title) const {
  auto found = std::ranges::find(columns, title, &RawColumn::title);
  if (found == columns.end()) found = std::ranges::find(columns, title, &RawColumn::name);
  if (found == columns.end()) {
    throw InputError(file.string() + ": no column " + Shown(title) + ": accepted is one of " +
                     Titles());
  }
  return static_cast<std::size_t>(found - columns.begin());
}

double RawTable::ToSi(std::size_t column, Quantity quantity, double without) const {
  const RawColumn& own = columns[column];
  if (!own.unknown_unit.empty() || (own.quantity && *own.quantity != quantity)) {
    throw InputError(Formatted("%s: column %s: expected %s", file.c_str(), Shown(own.title).c_str(),
                               InWords(quantity).c_str()));
  }
  return own.to_si.value_or(without);
}

std::string RawTable::Titles() const {
  std::string all;
  for (const RawColumn& column : columns) all.append(all.empty() ? "" : ", ").append(column.title);
  return Shown(all, 300);
}

RawTable ReadRawTable(const std::filesystem::path& file) {
  RawTable table{.file = file};
  CsvLines lines(file);
  while (lines.Next()) {
    const auto cells = CellsOf(lines);
    if (table.rows.empty() && HasWord(cells)) {
      table.columns.clear();
      for (const std::string_view cell : cells) table.columns.push_back(ColumnOf(cell));
    } else if (!table.rows.empty() || (cells.size() >= 2 && IsNumbers(cells))) {
      if (table.columns.empty()) {
        lines.Fail("numbers without a header: accepted is a line of column names above them");
      }
      AddRow(lines, &table);
    } else if (!table.columns.empty()) {
      AddRow(lines, &table);  // which says what is wrong with it
    }
  }
  if (table.columns.empty()) throw InputError(file.string() + ": no header: accepted is CSV");
  if (table.rows.empty()) throw InputError(file.string() + ": no row of numbers");
  return table;
}

}  // namespace palpate::identify
