// Counts how often the true force lies within the reported sigma, and which source caused the
// error.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace palpate::coverage {

enum class Phase : std::size_t { kEdge, kMoving, kStill, kFlagged };
inline constexpr std::array<const char*, 4> kPhaseNames{"near the edge", "moving", "still",
                                                        "not valid"};

// One estimate in contact. Forces in parts of the largest true one of its press [-].
struct EstimateRow {
  Phase phase = Phase::kMoving;
  // The error that sigma describes: of the magnitude, estimated less true, or of the vector.
  double error = 0;
  double off = 0;  // size of the error's vector
  double sigma = 0;
  // Part of `error` caused by the stated modulus, which differs from the true one.
  double material = 0;
};

// Results over all presses of one sense.
struct Bands {
  std::size_t count = 0;
  double one = 0, two = 0;     // share within one and two sigma [-]
  double z = 0, z_vector = 0;  // rms of error / sigma, and of the vector's error / sigma [-]
  double sigma = 0;            // median [-]
  double error = 0;            // rms [-]
  double material = 0;         // rms [-]
  double rest = 0;             // rms of the error that does not come from the material [-]
};
Bands BandsOf(const std::vector<EstimateRow>& rows);

// 95 % intervals of the shares within one and two sigma, by bootstrap over presses, because the
// estimates of one press have common errors (Efron 1979).
struct Interval {
  double least = 0, most = 0;
  [[nodiscard]] bool Overlaps(double low, double high) const {
    return least <= high && low <= most;
  }
};
struct Intervals {
  Interval one, two;
};
Intervals IntervalsOf(const std::vector<std::vector<EstimateRow>>& presses);

std::string Headline();
std::string InWords(const std::string& name, const Bands& bands);

}  // namespace palpate::coverage
