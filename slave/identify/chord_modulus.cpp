#include "slave/identify/chord_modulus.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace palpate::identify {
namespace {

struct Line {
  double slope = 0, sigma = 0;
  double offset = 0;  // at rest
};

std::optional<Line> FitLine(const std::vector<std::pair<double, double>>& points) {
  const auto count = static_cast<double>(points.size());
  if (points.size() < 3) return std::nullopt;
  double mx = 0, my = 0, xx = 0, xy = 0, yy = 0;
  for (const auto& [x, y] : points) mx += x / count, my += y / count;
  for (const auto& [x, y] : points) {
    xx += (x - mx) * (x - mx), xy += (x - mx) * (y - my), yy += (y - my) * (y - my);
  }
  if (!(xx > 0)) return std::nullopt;
  const double slope = xy / xx;
  const double sigma = std::sqrt(std::max(0.0, yy - slope * xy) / (count - 2) / xx);
  return Line{slope, sigma, my - slope * mx};
}

}  // namespace

std::optional<ChordModulus> ChordModulusOf(const MaterialTest& test) {
  if (test.kind != TestKind::kUniaxial || test.cauchy) return std::nullopt;
  double low = 0, high = 0;
  for (const TestRow& row : test.rows) {
    low = std::min(low, row.abscissa - 1), high = std::max(high, row.abscissa - 1);
  }
  ChordModulus chord{.compression = -low >= high};
  const double end = std::max(-low, high);
  const bool whole = end >= kChordTo;
  chord.to = whole ? kChordTo : end;
  chord.from = whole ? kChordFrom : 0;
  std::vector<std::pair<double, double>> points;
  for (const TestRow& row : test.rows) {
    const double size = (chord.compression ? -1 : 1) * (row.abscissa - 1);
    if (size >= chord.from && size <= chord.to) {
      points.emplace_back(row.abscissa - 1, row.measured.front());
    }
  }
  const auto line = FitLine(points);
  if (!line) return std::nullopt;
  chord.modulus = line->slope / test.end_factor;
  chord.sigma = line->sigma / test.end_factor;
  const double end_stress = line->slope * chord.to + (chord.compression ? -1 : 1) * line->offset;
  chord.excess = line->slope * chord.to / end_stress - 1;
  return chord;
}

}  // namespace palpate::identify
