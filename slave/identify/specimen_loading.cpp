#include "slave/identify/specimen_loading.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "shared/text/text.h"

namespace palpate::identify {
namespace {

// Returns the slope of the first stress over the strain of rows `from` to `to`, by least squares.
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

namespace {

// Rows between two turning points of the strain.
struct Leg {
  std::size_t from = 0, to = 0;  // rows [from, to)
  bool is_loading = true;        // whether the magnitude of the strain grows
};

// Splits the test at turning points. Reversals smaller than this fraction of the largest strain are
// noise.
std::vector<Leg> LegsOf(const MaterialTest& test) {
  constexpr double kTurn = 0.1;
  const double turn = kTurn * LargestStrain(test);
  const double begin = StrainOf(test, test.rows.front());
  const auto size = [&](std::size_t i) { return std::abs(StrainOf(test, test.rows[i]) - begin); };
  std::vector<Leg> legs;
  std::size_t from = 0, extreme = 0;
  int way = 0;  // direction of the strain: 1: growing, -1: falling, 0: unknown
  for (std::size_t i = 1; i < test.rows.size(); ++i) {
    const double since = size(i) - size(extreme);
    if (way == 0 && std::abs(since) > turn) way = since > 0 ? 1 : -1;
    if (way == 0) continue;
    if (way * since > 0) {
      extreme = i;
    } else if (-way * since > turn) {
      legs.push_back({from, extreme + 1, way > 0});
      from = extreme;
      extreme = i;
      way = -way;
    }
  }
  legs.push_back({from, test.rows.size(), way >= 0});
  return legs;
}

// Stress at a strain, linear between the rows of a leg.
double StressAt(const MaterialTest& test, const Leg& leg, double strain) {
  std::vector<std::pair<double, double>> curve;
  for (std::size_t i = leg.from; i < leg.to; ++i) {
    curve.emplace_back(StrainOf(test, test.rows[i]), test.rows[i].measured.front());
  }
  std::ranges::sort(curve);
  const auto after = std::ranges::lower_bound(curve, std::pair(strain, -HUGE_VAL));
  if (after == curve.begin()) return curve.front().second;
  if (after == curve.end()) return curve.back().second;
  const auto& [x0, y0] = *std::prev(after);
  const auto& [x1, y1] = *after;
  return x1 > x0 ? y0 + (strain - x0) / (x1 - x0) * (y1 - y0) : y0;
}

// Returns the mean distance of two legs over their common strains, relative to the largest stress.
double DistanceOf(const MaterialTest& test, const Leg& a, const Leg& b) {
  constexpr int kPlaces = 21;
  const auto range = [&](const Leg& leg) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (std::size_t i = leg.from; i < leg.to; ++i) {
      low = std::min(low, StrainOf(test, test.rows[i]));
      high = std::max(high, StrainOf(test, test.rows[i]));
    }
    return std::pair(low, high);
  };
  const auto [low_a, high_a] = range(a);
  const auto [low_b, high_b] = range(b);
  const double low = std::max(low_a, low_b), high = std::min(high_a, high_b);
  if (!(high > low)) return 0;
  double sum = 0;
  for (int k = 0; k < kPlaces; ++k) {
    const double strain = low + k * (high - low) / (kPlaces - 1);
    sum += std::abs(StressAt(test, a, strain) - StressAt(test, b, strain));
  }
  return sum / kPlaces / test.Peak();
}

}  // namespace

void KeepFirstLoading(MaterialTest* test) {
  // Mean distance relative to the largest stress that is a difference.
  constexpr double kDiffer = 0.03;
  const std::vector<Leg> legs = LegsOf(*test);
  const auto first = std::ranges::find_if(legs, &Leg::is_loading);
  if (legs.size() < 2 || first == legs.end() || first->to - first->from < kMinTestRows) return;
  double hysteresis = 0, softening = 0;
  std::string moduli;
  for (const Leg& leg : legs) {
    if (leg.to - leg.from < 2) continue;
    if (leg.is_loading) {
      softening = std::max(softening, DistanceOf(*test, *first, leg));
    } else if (&leg != legs.data()) {  // compares it with the previous leg
      hysteresis = std::max(hysteresis, DistanceOf(*test, *(&leg - 1), leg));
    }
    moduli += Formatted("%s%s %.3g kPa", moduli.empty() ? "" : ", ",
                        leg.is_loading ? "loading" : "unloading",
                        1e-3 * std::abs(SlopeOf(*test, leg.from, leg.to)));
  }
  if (std::max(hysteresis, softening) <= kDiffer) return;
  const std::string what = hysteresis <= kDiffer  ? "loadings"
                           : softening <= kDiffer ? "loading and unloading"
                                                  : "loading and unloading, and loadings,";
  test->remarks.push_back(test->name + ": the cycles differ: " + what +
                          Formatted(" by %.2g %% of the largest stress (mean slopes: %s): the "
                                    "first loading is used",
                                    100 * std::max(hysteresis, softening), moduli.c_str()));
  test->rows = {test->rows.begin() + static_cast<std::ptrdiff_t>(first->from),
                test->rows.begin() + static_cast<std::ptrdiff_t>(first->to)};
}

void TakeOffTravel(MaterialTest* test) {
  constexpr double kBeginning = 0.1;    // part of the range of strains that counts as first rows
  constexpr std::size_t kMinCount = 3;  // first rows
  constexpr double kNegligibleStrain = 0.005;  // of the largest strain
  // There is no load below this part of the expected load at the row's displacement.
  constexpr double kUnloaded = 0.25;
  // Multiple of the expected load above which the load has an offset, too.
  constexpr double kBoth = 4;
  // Multiples of the expected load within which a row belongs to the curve.
  constexpr double kMinRatio = 0.6, kMaxRatio = 1.6;
  std::vector<TestRow>& rows = test->rows;
  if (rows.size() < kMinCount + kMinTestRows || !(test->Peak() > 0)) return;
  const double begin = StrainOf(*test, rows.front()), largest = LargestStrain(*test);
  if (std::abs(begin) <= kNegligibleStrain * largest) return;
  std::size_t count = 1;
  while (count < rows.size() && (count < kMinCount || std::abs(StrainOf(*test, rows[count]) -
                                                               begin) < kBeginning * largest)) {
    ++count;
  }
  const double slope = SlopeOf(*test, 0, count), load = rows.front().measured.front();
  // A flat beginning is slack, see TakeOffBeginning.
  const auto farthest = std::ranges::max_element(
      rows, {}, [&](const TestRow& row) { return std::abs(StrainOf(*test, row) - begin); });
  const double mean = (farthest->measured.front() - load) / (StrainOf(*test, *farthest) - begin);
  if (!(slope * mean > 0) || std::abs(slope) < kUnloaded * std::abs(mean)) return;
  const double share = load / (slope * begin);
  if (std::abs(share) < kUnloaded) {
    const double offset = begin - load / slope;
    for (TestRow& row : rows) row.abscissa -= offset;
    test->remarks.push_back(
        test->name +
        Formatted(": the first row has %.3g %% strain without a load: an offset of the "
                  "travel, which is taken off",
                  100 * std::abs(offset)));
  } else if (share > kBoth) {  // TakeOffBeginning subtracts the load
    for (TestRow& row : rows) row.abscissa -= begin;
    test->remarks.push_back(test->name +
                            Formatted(": the first row has %.3g %% strain and a load of another "
                                      "cause: both are taken off as offsets",
                                      100 * std::abs(begin)));
  } else if (share < kMinRatio || share > kMaxRatio) {
    test->remarks.push_back(
        test->name + Formatted(": the first row has %.3g %% strain and %.2g times the load of so "
                               "much: travel, load or both may have an offset, which the table "
                               "cannot tell, and the modulus may be off: begin the table at rest",
                               100 * std::abs(begin), share));
  }
}

void TakeOffBeginning(MaterialTest* test) {
  constexpr double kContact = 0.01;     // of the largest load: more is loaded
  constexpr std::size_t kMinCount = 3;  // rows of slack
  constexpr double kFlat = 0.05;  // relative to the slope after contact; slack has a smaller slope
  // Relative to the largest load; a larger load is not the beginning.
  constexpr double kMaxAtRest = 0.5;
  constexpr double kConcave = 4;  // initial over mean slope of rubber, at most
  std::vector<TestRow>& rows = test->rows;
  if (rows.size() < kMinCount + kMinTestRows) return;
  const auto stress = [&](std::size_t i) { return rows[i].measured.front(); };
  const double peak = test->Peak();
  if (std::abs(stress(0)) > kMaxAtRest * peak) return;
  std::size_t loaded = 0;
  while (loaded < rows.size() && std::abs(stress(loaded) - stress(0)) <= kContact * peak) ++loaded;
  const bool has_slack =
      loaded >= kMinCount && loaded + 2 <= rows.size() &&
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

bool RemarkSoftBeginning(MaterialTest* test) {
  constexpr double kBeginning = 0.05;   // of the largest strain
  constexpr double kSofter = 0.7;       // relative to the slope of the next rows
  constexpr std::size_t kMinCount = 3;  // rows of a slope
  const double largest = LargestStrain(*test);
  const auto behind = std::ranges::find_if(test->rows, [&](const TestRow& row) {
    return std::abs(StrainOf(*test, row)) > kBeginning * largest;
  });
  const auto beginning = behind - test->rows.begin();
  const std::size_t rows = std::max(kMinCount, static_cast<std::size_t>(beginning));
  if (test->rows.size() < 3 * rows) return false;
  const double softer = SlopeOf(*test, 0, rows) / SlopeOf(*test, rows, 2 * rows);
  if (!(softer < kSofter)) return false;
  test->remarks.push_back(
      test->name + Formatted(": the slope of the first rows is %.2g of that of the next: a toe of "
                             "the test, or a material that stiffens; the modulus at rest is that "
                             "of the first rows",
                             softer));
  return true;
}

void RemarkOppositeKind(MaterialTest* test) {
  constexpr double kMinBend = 0.08, kMaxBend = 0.4;  // strain: a smaller one shows no bend
  // Stress E (e + bend e^2); for a neo-Hookean solid bend is -1 in tension and in compression (e <
  // 0).
  constexpr double kOpposite = 0.4;
  if (test->kind != TestKind::kUniaxial || LargestStrain(*test) < kMinBend) return;
  double a = 0, b = 0, c = 0, d = 0, e = 0;  // least squares of stress against e and e^2
  for (const TestRow& row : test->rows) {
    const double strain = StrainOf(*test, row), stress = row.measured.front();
    if (std::abs(strain) > kMaxBend) continue;
    const double square = strain * strain;
    a += square, b += square * strain, c += square * square;
    d += stress * strain, e += stress * square;
  }
  const double modulus = d * c - e * b, bend = e * a - d * b;
  if (!(bend > kOpposite * modulus)) return;
  const auto largest = std::ranges::max_element(
      test->rows, {}, [&](const TestRow& row) { return std::abs(StrainOf(*test, row)); });
  const bool is_tension = StrainOf(*test, *largest) > 0;
  test->remarks.push_back(
      test->name + Formatted(": read as %s, but the curve %s from rest: is it %s?",
                             is_tension ? "a tension" : "a compression",
                             is_tension ? "stiffens" : "softens",
                             is_tension ? "a compression, or a tissue whose fibres straighten"
                                        : "a tension, or a foam whose cells buckle"));
}

}  // namespace palpate::identify
