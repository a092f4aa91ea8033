// The modulus from presses with a known force, and its standard deviation.
#include "slave/identify/press_fit.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "slave/mechanics/factory/make_model.h"
#include "tests/slave/mechanics/contacts.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

// Noise in the forces of six presses spreads the fitted moduli as much as the fit states. The
// stated error of the model, which is the same in all draws, is added to that and subtracted here.
// Tolerance: three standard deviations of a spread of 60 draws, 27 %.
TEST(PressFit, StatesTheSpreadOfTheModulus) {
  Scene scene;
  scene.object.geometry = BoxGeometry{{0.06, 0.06, 0.06}, {4, 4, 4}};
  scene.object.material = {.young_modulus = 2e4, .poisson_ratio = 0.3, .density = 1000};
  scene.object.fixed = {Fixed{FixedPlane{2, 0}, {true, true, true}}};
  scene.model.kind = "fem-green";
  scene.model.range = 0.1;
  const auto model = MakeModel(scene, MeshObject(scene, std::nullopt));
  constexpr double kWidth = 0.03, kNoise = 0.02;  // [m], [N]
  constexpr int kDraws = 60;
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "presses.csv";
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, kNoise);
  double sum = 0, square = 0, stated = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    std::ofstream table(file);
    table << "case,x,y,z,dx,dy,dz,width,fx,fy,fz\n";
    for (int press = 0; press < 6; ++press) {
      const Vector3d p_O(0.02 + 0.004 * press, 0.03, 0.06), moved(0, 0, -1e-3);
      const Vector3d f = contacts::Answer(*model, contacts::Move(p_O, moved, kWidth)).force_O;
      table << press << "," << p_O.x() << ",0.03,0.06,0,0,-0.001," << kWidth;
      for (int axis = 0; axis < 3; ++axis) table << "," << f[axis] + noise(random);
      table << "\n";
    }
    table.close();
    const PressFit fit = FitPress(scene, file, 0, false, nullptr);
    sum += fit.young_modulus, square += fit.young_modulus * fit.young_modulus;
    const double of_model = fit.model_error * fit.young_modulus;
    EXPECT_GT(fit.model_error, 0);
    EXPECT_GT(fit.sigma_modulus, of_model);
    stated += fit.sigma_modulus * fit.sigma_modulus - of_model * of_model;
  }
  const double mean = sum / kDraws;
  const double spread = std::sqrt((square - kDraws * mean * mean) / (kDraws - 1));
  EXPECT_NEAR(mean, 2e4, 4 * spread / std::sqrt(kDraws));
  EXPECT_NEAR(std::sqrt(stated / kDraws) / spread, 1, 0.27);
}

}  // namespace
}  // namespace palpate
