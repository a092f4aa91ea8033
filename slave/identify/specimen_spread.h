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
// Half width of a 95 % interval over its sigma: Student's t of 13 degrees of freedom.
inline constexpr double kSpecimenWide = 2.16;

// Relative standard deviation of another specimen's modulus about the mean of these. Their own
// spread counts with its degrees of freedom beside the above; of one or none only the above.
double OtherSpecimenSigma(const std::vector<double>& moduli);

}  // namespace palpate::identify
