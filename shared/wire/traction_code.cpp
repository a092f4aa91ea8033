#include "shared/wire/traction_code.h"

#include <algorithm>
#include <cmath>

#include <zstd.h>

namespace palpate {
namespace {

constexpr int kLevel = 1;           // of zstd
constexpr int kMostSteps = 255;     // of the largest
constexpr double kMostUnit = 1e15;  // no material bears as much [Pa]
constexpr double kLeast = 1e-9;     // below it there is none [Pa]

NodeTraction InSteps(const std::vector<double>& pascals, double largest, int steps) {
  NodeTraction traction{largest > kLeast ? largest / steps : 1, {}};
  for (const double p : pascals) {
    traction.steps.push_back(static_cast<std::uint8_t>(std::lround(p / traction.unit)));
  }
  return traction;
}

}  // namespace

NodeTraction Quantised(const std::vector<double>& pascals, std::size_t budget) {
  const auto is_one = [](double p) { return p >= 0 && p <= kMostUnit; };  // so written, NaN is none
  if (pascals.empty() || !std::ranges::all_of(pascals, is_one)) return {};
  const double largest = std::ranges::max(pascals);
  for (int steps = kMostSteps; steps > 0; steps /= 2) {
    NodeTraction traction = InSteps(pascals, largest, steps);
    if (Packed(traction).size() <= budget) return traction;
  }
  return {};
}

std::string Packed(const NodeTraction& traction) {
  std::string packed(ZSTD_compressBound(traction.steps.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), traction.steps.data(),
                              traction.steps.size(), kLevel));
  return packed;
}

std::optional<NodeTraction> Unpacked(double unit, const std::string& packed, std::size_t nodes) {
  if (!(unit > 0 && unit <= kMostUnit)) return std::nullopt;
  NodeTraction traction{unit, std::vector<std::uint8_t>(nodes)};
  const std::size_t size =
      ZSTD_decompress(traction.steps.data(), nodes, packed.data(), packed.size());
  if (ZSTD_isError(size) != 0 || size != nodes) return std::nullopt;
  return traction;
}

}  // namespace palpate
