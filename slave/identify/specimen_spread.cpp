#include "slave/identify/specimen_spread.h"

#include <algorithm>
#include <cmath>

namespace palpate::identify {

double OtherSpecimenSigma(const std::vector<double>& moduli) {
  const auto count = static_cast<double>(std::max<std::size_t>(moduli.size(), 1));
  double mean = 0, square = kBetweenFreedom * kBetweenSpecimens * kBetweenSpecimens;
  for (const double modulus : moduli) mean += std::log(modulus) / count;
  for (const double modulus : moduli) square += std::pow(std::log(modulus) - mean, 2);
  return std::sqrt(square / (kBetweenFreedom + count - 1) * (1 + 1 / count));
}

}  // namespace palpate::identify
