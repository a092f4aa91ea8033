#include "slave/identify/test_beginning.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "shared/text/text.h"

namespace palpate::identify {
namespace {

// Slope of the first stress over the strain of rows `from` to `to`, by least squares.
double SlopeOf(const MaterialTest& test, std::size_t from, std::size_t to) {
  double x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t i = from; i < to; ++i) {
    const double strain = StrainOf(test, test.rows[i]), stress = test.rows[i].measured.front();
    x += strain, y += stress, xx += strain * strain, xy += strain * stress;
  }
  const auto n = static_cast<double>(to - from);
  const double spread = xx - x * x / n;
  return spread > 0 ? (xy - x * y / n) / spread : 0;
}

}  // namespace

double StrainOf(const MaterialTest& test, const TestRow& row) {
  return test.kind == TestKind::kShear ? row.abscissa : row.abscissa - 1;
}

double LargestStrain(const MaterialTest& test) {
  double largest = 0;
  for (const TestRow& row : test.rows) largest = std::max(largest, std::abs(StrainOf(test, row)));
  return largest;
}

void TakeOffBeginning(MaterialTest* test) {
  constexpr double kContact = 0.01;    // of the largest load: more is loaded
  constexpr std::size_t kFewest = 3;   // rows of slack
  constexpr double kFlat = 0.05;       // of the slope behind contact: slack is flatter
  constexpr double kMostAtRest = 0.5;  // of the largest load: more is no beginning
  constexpr double kConcave = 4;       // initial over mean slope of rubber, at most
  std::vector<TestRow>& rows = test->rows;
  if (rows.size() < kFewest + kLeastRows) return;
  const auto stress = [&](std::size_t i) { return rows[i].measured.front(); };
  const double peak = test->Peak();
  if (std::abs(stress(0)) > kMostAtRest * peak) return;
  std::size_t loaded = 0;
  while (loaded < rows.size() && std::abs(stress(loaded) - stress(0)) <= kContact * peak) ++loaded;
  const bool has_slack =
      loaded >= kFewest && loaded + 2 <= rows.size() &&
      std::abs(SlopeOf(*test, 0, loaded)) < kFlat * std::abs(SlopeOf(*test, loaded, loaded + 2));
  const double largest = LargestStrain(*test);
  double at_rest = 0, slack = 0;
  if (has_slack) {
    for (std::size_t i = 0; i < loaded; ++i) at_rest += stress(i) / static_cast<double>(loaded);
    const double before = StrainOf(*test, rows[loaded - 1]), after = StrainOf(*test, rows[loaded]);
    const double contact = after - (stress(loaded) - at_rest) / SlopeOf(*test, loaded, loaded + 2);
    slack = std::clamp(contact, std::min(before, after), std::max(before, after));
    rows.erase(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(loaded));
  } else if (std::abs(stress(0)) >
             peak * (kContact + kConcave * std::abs(StrainOf(*test, rows[0])) / largest)) {
    at_rest = stress(0);
  }
  for (TestRow& row : rows) row.abscissa -= slack, row.measured.front() -= at_rest;
  if (slack != 0) {
    test->remarks.push_back(test->name + Formatted(": slack of %.3g %% strain before the specimen "
                                                   "is loaded is taken off",
                                                   100 * std::abs(slack)));
  }
  if (std::abs(at_rest) > kContact * peak) {
    test->remarks.push_back(
        test->name + Formatted(": the load at rest, %.3g %% of the largest, is a preload or an "
                               "offset and is taken off",
                               100 * std::abs(at_rest) / peak));
  }
}

void RemarkSoftBeginning(MaterialTest* test) {
  constexpr double kBeginning = 0.05;  // of the largest strain
  constexpr double kSofter = 0.7;      // of the slope in the next rows
  constexpr std::size_t kFewest = 3;   // rows of a slope
  const double largest = LargestStrain(*test);
  const auto behind = std::ranges::find_if(test->rows, [&](const TestRow& row) {
    return std::abs(StrainOf(*test, row)) > kBeginning * largest;
  });
  const auto beginning = behind - test->rows.begin();
  const std::size_t rows = std::max(kFewest, static_cast<std::size_t>(beginning));
  if (test->rows.size() < 3 * rows) return;
  const double softer = SlopeOf(*test, 0, rows) / SlopeOf(*test, rows, 2 * rows);
  if (!(softer < kSofter)) return;
  test->remarks.push_back(
      test->name + Formatted(": the slope of the first rows is %.2g of that of the next: a toe of "
                             "the test, or a material that stiffens; the modulus at rest is that "
                             "of the first rows",
                             softer));
}

}  // namespace palpate::identify
