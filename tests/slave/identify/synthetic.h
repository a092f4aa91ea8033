// Material tests of known laws, which the tests of `identify` fit.
#pragma once

#include <random>
#include <vector>

#include "slave/identify/material_test.h"

namespace palpate::identify {

// A curve of `law` from rest to `end`, each stress with the noise of its peak.
inline MaterialTest CurveOf(const HyperLaw& law, TestKind kind, double end, int rows,
                            double noise = 0, unsigned seed = 1) {
  MaterialTest test{.kind = kind, .name = "test", .components = {{0, 0}}};
  if (kind == TestKind::kShear) test.components = {{0, 1}};
  const double rest = kind == TestKind::kShear ? 0 : 1;
  for (int i = 1; i <= rows; ++i) {
    test.rows.push_back({.abscissa = rest + (end - rest) * i / rows, .measured = {0}});
  }
  const Eigen::VectorXd predicted = Predict(law, test);
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal(0, noise * predicted.cwiseAbs().maxCoeff());
  for (std::size_t i = 0; i < test.rows.size(); ++i) {
    test.rows[i].measured = {predicted[static_cast<Eigen::Index>(i)] +
                             (noise > 0 ? normal(engine) : 0)};
  }
  return test;
}

inline const LawFamily& Family(std::string_view name) {
  for (const LawFamily& family : OfferedLaws()) {
    if (family.name == name) return family;
  }
  throw std::invalid_argument(std::string(name));
}

}  // namespace palpate::identify
