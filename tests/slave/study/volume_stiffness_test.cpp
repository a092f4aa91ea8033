#include "slave/study/volume_stiffness.h"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

namespace palpate::study {
namespace {

constexpr double kCubeE = 1e5, kCubeNu = 0.3, kCubeSide = 0.06;

Scene StiffnessCube() {
  Scene scene;
  scene.object.geometry = BoxGeometry{{kCubeSide, kCubeSide, kCubeSide}, {3, 3, 3}};
  scene.object.material = {kCubeE, kCubeNu, 0, 0};
  scene.object.fixed = {{FixedPlane{2, 0}, {true, true, true}}};
  return scene;
}

Press OnTop(double x, double y) {
  return {{x, y, kCubeSide}, -Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX()};
}

// References for the force per depth: a bonded rigid disc on a half-space needs E w ln(3 - 4 nu) /
// ((1 + nu) (1 - 2 nu)) (Spence, Proc. R. Soc. A 305, 1968), Boussinesq's flat punch without
// friction needs E w / (1 - nu^2). Tolerance: with a tool of a twentieth of the cube the fixed
// bottom adds (1 + nu) (3 - 2 nu) / (2 pi) 1.13 w / side = 2.8 %, the free sides reduce this, and
// the mesh is accurate to 1 %.
TEST(VolumeStiffness, OfASmallToolIsThatOnAHalfSpace) {
  const double w = kCubeSide / 20;
  for (const auto& [law, half_space] :
       {std::pair{ContactLaw::kBonded,
                  kCubeE * w * std::log(3 - 4 * kCubeNu) / ((1 + kCubeNu) * (1 - 2 * kCubeNu))},
        {ContactLaw::kFrictionless, kCubeE * w / (1 - kCubeNu * kCubeNu)}}) {
    Scene scene = StiffnessCube();
    scene.model.contact = law;
    const auto found = VolumeStiffness(scene, OnTop(0.03, 0.03), w, w / 3);
    ASSERT_TRUE(found);
    EXPECT_NEAR(*found / half_space, 1, 0.05) << static_cast<int>(law);
  }
}

TEST(VolumeStiffness, IsNotKnownWhereNothingHoldsTheObject) {
  Scene scene = StiffnessCube();
  scene.object.fixed.clear();
  EXPECT_FALSE(VolumeStiffness(scene, OnTop(0.03, 0.03), 0.01, 0.004));
}

}  // namespace
}  // namespace palpate::study
