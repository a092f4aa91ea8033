// OtherSpecimenSigma estimates how much the moduli of specimens of one material differ: another
// mix, another mould, another day.
#pragma once

#include <vector>

namespace palpate::identify {

// Standard deviation of the logarithm of the chord modulus over specimens of one material [-]
// [recorded: silicone_compression, samples A1 and B1 of 13 materials, 13 degrees of freedom; the
// data's own table states 2.6 to 5.8 %, for the softest 14 %].
inline constexpr double kBetweenSpecimens = 0.0325;
inline constexpr int kBetweenFreedom = 13;
// Half width of a 95 % interval relative to its sigma: Student's t for 13 degrees of freedom.
inline constexpr double kSpecimenWide = 2.16;
// The same of a normal distribution.
inline constexpr double kNormalWide = 1.96;

// Returns the relative standard deviation of another specimen's modulus about the mean of these.
// Their spread is combined with the value above, weighted by its degrees of freedom; for one or no
// specimen only the value above is used.
double OtherSpecimenSigma(const std::vector<double>& moduli);

}  // namespace palpate::identify
