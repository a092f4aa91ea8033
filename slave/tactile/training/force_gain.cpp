#include "slave/tactile/training/force_gain.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace palpate {

double FitForceGain(std::span<const Eigen::Vector3f> estimated,
                    std::span<const Eigen::Vector3f> measured) {
  double product = 0, square = 0;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const auto e = static_cast<double>(estimated[i].z()), m = static_cast<double>(measured[i].z());
    product += e * m;
    square += e * e;
  }
  const double gain = product / square;
  if (!(std::isfinite(gain) && gain > 0)) {
    throw std::invalid_argument(
        "no gain makes the network's fz that of the recording (" + std::to_string(gain) +
        "): accepted are contacts whose fz has the network's sign, force of the fingertip on the "
        "object");
  }
  return gain;
}

}  // namespace palpate
