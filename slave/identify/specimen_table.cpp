#include "slave/identify/specimen_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include <Eigen/LU>

#include "shared/text/text.h"
#include "slave/identify/bonded_cylinder.h"
#include "slave/identify/raw_table.h"
#include "slave/identify/specimen_loading.h"

namespace palpate::identify {
namespace {

constexpr std::size_t kMaxRows = 240;  // more are averaged, because neighbours are nearly equal
constexpr double kMinStretch = 0.02, kMaxStretch = 50;
constexpr double kMaxStress = 1e13;  // [Pa]

enum class Measure { kStretch, kStrain, kDisplacement };
struct Abscissa {
  std::size_t column = 0;
  Measure measure = Measure::kStretch;
};
enum class Load { kNominal, kCauchy, kForce };
struct Ordinate {
  std::size_t column = 0;
  Load load = Load::kNominal;
};

[[noreturn]] void FailAt(const RawTable& table, std::size_t row, const std::string& what) {
  throw InputError(table.file.string() + ":" + std::to_string(table.lines[row]) + ": " + what);
}

double AreaOf(const Specimen& specimen) {
  if (specimen.area) return *specimen.area;
  if (specimen.diameter) return std::numbers::pi / 4 * *specimen.diameter * *specimen.diameter;
  throw std::invalid_argument(
      "forces need the specimen's section: expected --area or --diameter, or a column of "
      "stress");
}

double HeightOf(const Specimen& specimen) {
  if (specimen.height) return *specimen.height;
  throw std::invalid_argument(
      "displacements need the specimen's length at rest: expected --height, or a column of "
      "strain or stretch");
}

bool HasSizes(const Specimen& specimen) {
  return specimen.height && (specimen.area || specimen.diameter);
}

constexpr std::initializer_list<std::string_view> kDisplacements = {
    "displacement", "compression", "extension", "indentation", "travel", "depth", "crosshead"};

std::optional<Abscissa> FindDisplacement(const RawTable& table) {
  if (const auto c = table.Find(kDisplacements)) return Abscissa{*c, Measure::kDisplacement};
  return std::nullopt;
}

// Returns the quantity of a column: its unit decides, then its name.
Measure MeasureOf(const RawTable& table, std::size_t c, bool shear) {
  const RawColumn& column = table.columns[c];
  const auto has = [&](std::string_view word) {
    return column.name.find(word) != std::string::npos;
  };
  if (has("strain") && (has("true") || has("log") || has("hencky"))) {
    throw InputError(table.file.string() + ": column " + Shown(column.title) +
                     ": expected engineering strain (change of length over length at rest) or "
                     "stretch, not true strain");
  }
  if (column.quantity == Quantity::kLength) {
    if (has("strain") || has("stretch"))
      static_cast<void>(table.ToSi(c, Quantity::kNumber, 1));  // refuses it
    return Measure::kDisplacement;
  }
  if (has("strain") || has("dehnung") || has("stauchung") || shear) return Measure::kStrain;
  if (has("stretch") || has("lambda") || column.name == "f11") return Measure::kStretch;
  if (column.quantity == Quantity::kNumber) return Measure::kStrain;
  const bool is_length = std::ranges::any_of(kDisplacements, has);
  return is_length ? Measure::kDisplacement : Measure::kStretch;
}

std::optional<Ordinate> FindForce(const RawTable& table) {
  if (const auto c = table.Find({"force", "load", "f"})) return Ordinate{*c, Load::kForce};
  return std::nullopt;
}

Abscissa FindAbscissa(const RawTable& table, const Specimen& specimen, bool shear) {
  if (!specimen.abscissa.empty()) {
    const std::size_t c = table.Named(specimen.abscissa);
    return {c, MeasureOf(table, c, shear)};
  }
  if (HasSizes(specimen) && FindForce(table)) {
    if (const auto found = FindDisplacement(table)) return *found;
  }
  if (shear) {
    if (const auto c = table.Find(
            {"shear", "gamma", "amount of shear", "shear strain", "strain", "stretch", "lambda"})) {
      return {*c, Measure::kStrain};
    }
  }
  if (const auto c = table.Find({"stretch", "lambda", "stretch 1", "lambda 1", "lambda1", "f11"})) {
    return {*c, Measure::kStretch};
  }
  if (const auto c = table.Find({"strain", "engineering strain", "nominal strain", "eps"})) {
    return {*c, Measure::kStrain};
  }
  if (const auto found = FindDisplacement(table)) return *found;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    static_cast<void>(MeasureOf(table, c, shear));  // refuses true strain
  }
  throw InputError(table.file.string() + ": no deformation: expected a column " +
                   (shear ? "shear, gamma or strain" : "stretch, strain or displacement") +
                   ", or --x NAME; there are " + table.Titles());
}

Ordinate FindOrdinate(const RawTable& table, const Specimen& specimen, bool shear) {
  if (!specimen.ordinate.empty()) {
    const std::size_t c = table.Named(specimen.ordinate);
    const std::string& name = table.columns[c].name;
    const auto has = [&](std::string_view word) { return name.find(word) != std::string::npos; };
    const auto quantity = table.columns[c].quantity;
    const bool named_force = has("force") || has("load");
    if (quantity ? quantity == Quantity::kForce : named_force) {
      if (has("stress"))
        static_cast<void>(table.ToSi(c, Quantity::kStress, 1));  // refuses a stress in N
      return {c, Load::kForce};
    }
    if (named_force)
      static_cast<void>(table.ToSi(c, Quantity::kForce, 1));  // refuses a force in Pa
    return {c, has("true") || has("cauchy") || has("sigma") ? Load::kCauchy : Load::kNominal};
  }
  if (HasSizes(specimen)) {
    if (const auto found = FindForce(table)) return *found;
  }
  if (shear) {
    if (const auto c = table.Find({"p12", "shear stress", "tau"})) return {*c, Load::kNominal};
    if (const auto c = table.Find({"sigma12"})) return {*c, Load::kCauchy};
  }
  if (const auto c =
          table.Find({"p11", "p", "stress", "engineering stress", "nominal stress", "pk1"})) {
    return {*c, Load::kNominal};
  }
  if (const auto c = table.Find({"sigma11", "sigma", "true stress", "cauchy", "cauchy stress"})) {
    return {*c, Load::kCauchy};
  }
  if (const auto found = FindForce(table)) return *found;
  throw InputError(table.file.string() +
                   ": no load: expected a column stress, P, sigma or force, or --y NAME; there "
                   "are " +
                   table.Titles());
}

double StressFactor(const RawTable& table, std::size_t column, Load load,
                    const Specimen& specimen) {
  if (load == Load::kForce) return table.ToSi(column, Quantity::kForce, 1) / AreaOf(specimen);
  return table.ToSi(column, Quantity::kStress, specimen.stress_unit.value_or(1));
}

bool NamesUnit(const RawTable& table, const Ordinate& y, const Specimen& specimen) {
  return table.columns[y.column].to_si || (y.load != Load::kForce && specimen.stress_unit);
}

// Strain of the first kind: stretch - 1, or amount of shear.
double StrainFactor(const RawTable& table, std::size_t column, Measure measure,
                    const Specimen& specimen) {
  if (measure == Measure::kDisplacement) {
    return table.ToSi(column, Quantity::kLength, 1) / HeightOf(specimen);
  }
  return table.ToSi(column, Quantity::kNumber, 1);
}

TestKind KindOf(const TableRequest& request) {
  static constexpr std::array<std::pair<std::string_view, TestKind>, 8> kKinds{
      {{"uniaxial", TestKind::kUniaxial},
       {"tension", TestKind::kUniaxial},
       {"compression", TestKind::kUniaxial},
       {"equibiaxial", TestKind::kEquibiaxial},
       {"planar", TestKind::kPlanar},
       {"biaxial", TestKind::kBiaxial},
       {"shear", TestKind::kShear},
       {"tensor", TestKind::kTensor}}};
  for (const auto& [name, kind] : kKinds) {
    if (name == request.kind) return kind;
  }
  throw std::invalid_argument(
      Shown(request.kind) + "=" + request.file.string() +
      ": expected uniaxial, tension, compression, equibiaxial, planar, biaxial, shear, tensor, "
      "relaxation or press");
}

// Machines report a compression with either sign: it shortens, and its stress presses.
void MakeCompressive(MaterialTest* test) {
  double strain = 0, stress = 0;
  for (const TestRow& row : test->rows) {
    if (std::abs(row.abscissa - 1) > std::abs(strain)) {
      strain = row.abscissa - 1, stress = row.measured.front();
    }
  }
  for (TestRow& row : test->rows) {
    if (strain > 0) row.abscissa = 2 - row.abscissa;
    if (stress > 0) row.measured.front() *= -1;
    if (row.abscissa > kMinStretch) continue;
    throw InputError(test->name + Formatted(": a compression to a stretch of %g: expected 0.02 "
                                            "or more. Check the units: those of the header and "
                                            "--height",
                                            row.abscissa));
  }
}

void CheckRow(const RawTable& table, std::size_t i, const MaterialTest& test, const TestRow& row) {
  const bool shear = test.kind == TestKind::kShear;
  const bool possible = shear ? std::abs(row.abscissa) < kMaxStretch
                              : row.abscissa > kMinStretch && row.abscissa < kMaxStretch &&
                                    row.across > kMinStretch && row.across < kMaxStretch;
  if (!possible) {
    FailAt(table, i,
           Formatted("%s = %g: expected %s", shear ? "amount of shear" : "stretch", row.abscissa,
                     shear ? "-50 to 50"
                           : "0.02 to 50; is the strain in percent? Then write its "
                             "unit %"));
  }
  for (const double stress : row.measured) {
    if (!(std::abs(stress) < kMaxStress)) FailAt(table, i, "a stress beyond 1e13 Pa");
  }
}

TestRow AverageOf(const std::vector<TestRow>& rows, std::size_t from, std::size_t to) {
  TestRow mean = rows[from];
  for (std::size_t i = from + 1; i < to; ++i) {
    mean.abscissa += rows[i].abscissa, mean.across += rows[i].across;
    for (std::size_t c = 0; c < mean.measured.size(); ++c) mean.measured[c] += rows[i].measured[c];
  }
  const auto count = static_cast<double>(to - from);
  mean.abscissa /= count, mean.across /= count;
  for (double& value : mean.measured) value /= count;
  return mean;
}

void Thin(std::vector<TestRow>* rows) {
  if (rows->size() <= kMaxRows) return;
  std::vector<TestRow> few;
  for (std::size_t i = 0; i < kMaxRows; ++i) {
    few.push_back(AverageOf(*rows, i * rows->size() / kMaxRows, (i + 1) * rows->size() / kMaxRows));
  }
  *rows = std::move(few);
}

void Finish(const RawTable& table, const Specimen& specimen, MaterialTest* test) {
  if (test->rows.size() < kMinTestRows) {
    throw TooFewRows(Formatted("%s: %zu rows between --from and --to: expected %zu or more",
                               table.file.c_str(), test->rows.size(), kMinTestRows));
  }
  if (!(test->Peak() > 0)) throw InputError(table.file.string() + ": every stress is zero");
  if (test->kind != TestKind::kTensor) Thin(&test->rows);
  if (!specimen.bonded || test->kind != TestKind::kUniaxial) return;
  if (!specimen.diameter || !specimen.height) {
    throw std::invalid_argument("--ends bonded: needs --diameter and --height of a cylinder");
  }
  test->end_factor =
      BondedCylinderFactor(*specimen.diameter / *specimen.height, specimen.poisson_ratio);
}

// Returns the largest distance of the curve from the straight line to its last row, relative to the
// largest stress.
double BowOf(const MaterialTest& test) {
  const TestRow& last = test.rows.back();
  const double slope = last.measured.front() / StrainOf(test, last);
  double bow = 0;
  for (const TestRow& row : test.rows) {
    bow = std::max(bow, std::abs(row.measured.front() - slope * StrainOf(test, row)));
  }
  return bow / test.Peak();
}

// Checks a strain beyond 100 % without unit: it is that of a rubber with a curved stress-strain
// curve, or a number of percent or millimetres.
void CheckUnitOfStrain(const RawTable& table, const Abscissa& x, MaterialTest* test) {
  constexpr double kMaxStrain = 20, kStraight = 0.04;  // strain, bow
  const double largest = LargestStrain(*test);
  const bool named = x.measure == Measure::kStretch || table.columns[x.column].to_si;
  if (named || largest <= 1) return;
  test->units_named = false;
  if (largest > kMaxStrain || BowOf(*test) < kStraight) {
    throw InputError(
        Formatted("%s: column %s: strains up to %.4g %% on a curve that is straight, "
                  "or beyond any rubber: expected a column that names its unit, "
                  "%% (percent), mm/mm or a length",
                  table.file.c_str(), Shown(table.columns[x.column].title).c_str(), 100 * largest));
  }
  test->remarks.push_back(
      test->name + Formatted(": strains up to %.4g %% in a column without a unit: if these are "
                             "percent, write the unit %%",
                             100 * largest));
}

// Strains that begin at 1 without a load are stretches.
void RefuseStretchAsStrain(const RawTable& table, const Abscissa& x, const MaterialTest& test) {
  // Tolerance around 1; fraction of the largest stress.
  constexpr double kNear = 0.05, kUnloaded = 0.05;
  const TestRow& first = test.rows.front();
  if (x.measure != Measure::kStrain || test.kind == TestKind::kShear) return;
  if (std::abs(StrainOf(test, first) - 1) > kNear) return;
  if (std::abs(first.measured.front()) > kUnloaded * test.Peak()) return;
  throw InputError(
      Formatted("%s:%d: column %s begins at %.4g, where the specimen bears no load: "
                "is it a stretch, or in percent? Then expected the name stretch or the unit %%",
                table.file.c_str(), static_cast<int>(table.lines.front()),
                Shown(table.columns[x.column].title).c_str(), StrainOf(test, first)));
}

// Load divided by stress must be the loaded area, and displacement divided by strain the height:
// those of the options, or else plausible ones for a specimen. A wrong unit contradicts this.
void CheckColumns(const RawTable& table, const Specimen& specimen) {
  // Accepted factor, since machines may use the dimensions of another specimen.
  constexpr double kTimes = 3;
  constexpr double kFlattest = 20, kSlimmest = 0.01;  // width over height
  const auto force = table.Find({"force", "load", "f"});
  const auto stress = table.Find({"p11", "p", "stress", "engineering stress", "nominal stress"});
  const auto displacement = table.Find(kDisplacements);
  const auto strain = table.Find({"strain", "engineering strain", "nominal strain"});
  if (!force || !stress || !displacement || !strain) return;
  double area = 0, height = 0, largest = 0;
  for (const std::vector<double>& row : table.rows) {
    if (!(std::abs(row[*force]) > largest) || row[*stress] == 0 || row[*strain] == 0) continue;
    largest = std::abs(row[*force]);
    area = largest * table.ToSi(*force, Quantity::kForce, 1) /
           std::abs(row[*stress] *
                    table.ToSi(*stress, Quantity::kStress, specimen.stress_unit.value_or(1)));
    height = std::abs(row[*displacement] * table.ToSi(*displacement, Quantity::kLength, 1) /
                      (row[*strain] * table.ToSi(*strain, Quantity::kNumber, 1)));
  }
  const auto require = [&](bool possible, const char* columns, double value, double accepted) {
    if (possible) return;
    throw InputError(
        Formatted("%s: the columns of %s are of a specimen of %.3g, against %.3g: "
                  "Check the units: those of the header, --stress-unit, --height, "
                  "--diameter and --area",
                  table.file.c_str(), columns, value, accepted));
  };
  if (!(area > 0 && height > 0)) return;
  if (HasSizes(specimen)) {
    const double ratio = area / AreaOf(specimen);
    const bool named = specimen.stress_unit || table.columns[*stress].to_si;
    require(!named || (ratio < kTimes && ratio > 1 / kTimes), "load and stress [m2]", area,
            AreaOf(specimen));
    return;
  }
  const double shape = std::sqrt(area) / height;
  require(shape < kFlattest && shape > kSlimmest, "load, stress, displacement and strain [m]",
          std::sqrt(area), height);
}

bool InRange(const Specimen& specimen, double strain) {
  return std::abs(strain) >= specimen.from && std::abs(strain) <= specimen.to;
}

// Columns F11 ... F33 and P11 ... P33 or sigma11 ... sigma33; a stress that is zero throughout was
// not measured.
MaterialTest ReadTensor(const RawTable& table, const Specimen& specimen) {
  MaterialTest test{.kind = TestKind::kTensor, .name = table.file.stem().string()};
  std::array<std::optional<std::size_t>, 9> F, S;
  test.cauchy = !table.Find({"p11"}) && table.Find({"sigma11"});
  for (std::size_t i = 0; i < 9; ++i) {
    const std::string at{static_cast<char>('1' + i / 3), static_cast<char>('1' + i % 3)};
    F[i] = table.Find({std::string_view("f" + at)});
    S[i] = table.Find({std::string_view((test.cauchy ? "sigma" : "p") + at)});
    if (!F[i]) {
      throw InputError(table.file.string() + ": no column F" + at +
                       ": expected KIND=FILE, or columns F11 to F33 with P11 ... or sigma11 ...");
    }
  }
  const auto measured = [&](std::size_t c) {
    return S[c] && std::ranges::any_of(table.rows, [&](const auto& r) { return r[*S[c]] != 0; });
  };
  for (std::size_t c = 0; c < 9; ++c) {
    if (!measured(c)) continue;
    test.components.emplace_back(c / 3, c % 3);
    test.units_named &= specimen.stress_unit || table.columns[*S[c]].to_si;
  }
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    TestRow row;
    for (std::size_t c = 0; c < 9; ++c) {
      row.F(static_cast<Eigen::Index>(c / 3), static_cast<Eigen::Index>(c % 3)) =
          table.At(i, *F[c]);
      if (!measured(c)) continue;
      row.measured.push_back(table.At(i, *S[c]) *
                             StressFactor(table, *S[c], Load::kNominal, specimen));
    }
    if (!(row.F.determinant() > 1e-6)) FailAt(table, i, "det F: expected above 0");
    CheckRow(table, i, test, row);
    test.rows.push_back(row);
  }
  Finish(table, specimen, &test);
  return test;
}

// The second stress, along the second stretch, where it was measured.
std::optional<std::size_t> SecondStress(const RawTable& table, const MaterialTest& test) {
  if (test.kind == TestKind::kUniaxial || test.kind == TestKind::kShear) return std::nullopt;
  const auto found = test.cauchy ? table.Find({"sigma22"}) : table.Find({"p22", "stress 2"});
  if (!found) return std::nullopt;
  const bool any = std::ranges::any_of(table.rows, [&](const auto& r) { return r[*found] != 0; });
  return any ? found : std::nullopt;
}

// If several tests were appended to each other, time decreases between them.
void RemarkTime(const RawTable& table, MaterialTest* test) {
  const auto time = table.Find({"t", "time", "step time", "test time", "elapsed time"});
  if (!time) return;
  for (std::size_t i = 1; i < table.rows.size(); ++i) {
    if (!(table.rows[i][*time] < table.rows[i - 1][*time])) continue;
    test->remarks.push_back(test->name + ": the time runs back in line " +
                            std::to_string(table.lines[i]) +
                            ": more than one test in a table? Write each into a file of its own");
    return;
  }
}

void AddRow(const RawTable& table, std::size_t i, const TestRow& row, MaterialTest* test) {
  CheckRow(table, i, *test, row);
  test->rows.push_back(row);
}

}  // namespace

MaterialTest ReadTest(const TableRequest& request, const Specimen& specimen) {
  const RawTable table = ReadRawTable(request.file);
  if (request.kind.empty() || request.kind == "tensor") return ReadTensor(table, specimen);
  MaterialTest test{.kind = KindOf(request), .name = request.file.stem().string()};
  const bool shear = test.kind == TestKind::kShear;
  const Abscissa x = FindAbscissa(table, specimen, shear);
  const Ordinate y = FindOrdinate(table, specimen, shear);
  test.cauchy = y.load == Load::kCauchy;
  test.components = {shear ? std::pair(0, 1) : std::pair(0, 0)};
  const auto second = SecondStress(table, test);
  if (second) test.components.emplace_back(1, 1);
  const auto across = table.Find({"stretch 2", "lambda 2", "lambda2", "f22"});
  if (test.kind == TestKind::kBiaxial && request.across == 0 && !across) {
    throw InputError(table.file.string() +
                     ": biaxial needs the second stretch: expected a column stretch_2, or "
                     "biaxial:RATIO=FILE, with the ratio of the second strain to the first");
  }
  const double by = StrainFactor(table, x.column, x.measure, specimen);
  const double stress = StressFactor(table, y.column, y.load, specimen);
  CheckColumns(table, specimen);
  test.units_named = NamesUnit(table, y, specimen);
  if (specimen.area || specimen.diameter) test.area = AreaOf(specimen);
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const double strain = by * table.At(i, x.column) - (x.measure == Measure::kStretch ? 1 : 0);
    if (!InRange(specimen, strain)) continue;
    TestRow row{.abscissa = shear ? strain : 1 + strain};
    if (test.kind == TestKind::kBiaxial) {
      row.across = request.across != 0 ? 1 + request.across * strain : table.At(i, *across);
    }
    row.measured = {stress * table.At(i, y.column)};
    if (second) {
      row.measured.push_back(table.At(i, *second) *
                             StressFactor(table, *second, Load::kNominal, specimen));
    }
    AddRow(table, i, row, &test);
  }
  if (specimen.from == 0 && !test.rows.empty()) {
    KeepFirstLoading(&test);
    RefuseStretchAsStrain(table, x, test);
    TakeOffTravel(&test);
  }
  RemarkTime(table, &test);
  if (request.kind == "compression" && !test.rows.empty()) MakeCompressive(&test);
  if (!test.rows.empty()) CheckUnitOfStrain(table, x, &test);
  if (specimen.from == 0 && !test.rows.empty()) {
    TakeOffBeginning(&test);
    if (!RemarkSoftBeginning(&test)) RemarkOppositeKind(&test);
  }
  Finish(table, specimen, &test);
  return test;
}

// An instrument's relaxation modulus is E in tension and G in shear, which is a third of E.
void RequireKnownKind(const RawTable& table, std::size_t strain, bool shear) {
  const std::string& name = table.columns[strain].name;
  const bool is_named = shear || name.find("tens") != std::string::npos ||
                        name.find("compress") != std::string::npos ||
                        name.find("stretch") != std::string::npos;
  if (is_named || !table.Find({"relaxation modulus", "g(t)", "e(t)"})) return;
  throw InputError(table.file.string() + ": column " + Shown(table.columns[strain].title) +
                   ": of an instrument that writes a relaxation modulus it may be a shear: "
                   "expected the name Shear strain, or Tensile strain or Compressive strain");
}

RelaxationTable ReadRelaxation(const TableRequest& request, const Specimen& specimen) {
  const RawTable table = ReadRawTable(request.file);
  const auto time = table.Find({"t", "time", "step time", "test time", "elapsed time"});
  if (!time) {
    throw InputError(table.file.string() + ": no column time: there are " + table.Titles());
  }
  const Abscissa x = FindAbscissa(table, specimen, true);
  const Ordinate y = FindOrdinate(table, specimen, true);
  const double by = StrainFactor(table, x.column, x.measure, specimen);
  const double stress = StressFactor(table, y.column, y.load, specimen);
  const std::string& words = table.columns[x.column].name;
  RelaxationTable relaxation{.name = table.file.stem().string(),
                             .units_named = NamesUnit(table, y, specimen)};
  relaxation.shear =
      words.find("shear") != std::string::npos || words.find("gamma") != std::string::npos;
  RequireKnownKind(table, x.column, relaxation.shear);
  const bool stretch = words.starts_with("stretch") || words.starts_with("lambda");
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const double t = table.At(i, *time) * table.ToSi(*time, Quantity::kTime, 1);
    if (i > 0 && t < relaxation.time.back()) FailAt(table, i, "the time decreases");
    relaxation.time.push_back(t);
    relaxation.strain.push_back(by * table.At(i, x.column) - (stretch ? 1 : 0));
    relaxation.stress.push_back(stress * table.At(i, y.column));
  }
  if (relaxation.time.size() < kMinTestRows) {
    throw TooFewRows(Formatted("%s: %zu rows: expected %zu or more", table.file.c_str(),
                               relaxation.time.size(), kMinTestRows));
  }
  return relaxation;
}

}  // namespace palpate::identify
