#include "slave/identify/bonded_cylinder.h"

#include <stdexcept>

#include <gtest/gtest.h>

namespace palpate::identify {
namespace {

// The ends of a slender rod have no influence; without lateral strain they never have one.
TEST(BondedCylinder, SlenderOrWithoutPoissonsEffectItIsFree) {
  EXPECT_NEAR(BondedCylinderFactor(0.02, 0.5), 1, 0.01);
  EXPECT_NEAR(BondedCylinderFactor(1.67, 0), 1, 1e-9);
}

// A wide disc between plates: 1 + 2 S^2 with S = diameter / (4 height) (Gent and Lindley 1959) for
// the incompressible, within 5 % from S = 2.5 on; the modulus at no lateral strain for others,
// which the free edge, of about one height, lowers.
TEST(BondedCylinder, AFlatCylinderIsTheKnownDisc) {
  for (const double slenderness : {10.0, 16.0}) {
    const double S = slenderness / 4;
    EXPECT_NEAR(BondedCylinderFactor(slenderness, 0.5) / (1 + 2 * S * S), 1, 0.05) << slenderness;
  }
  const double nu = 0.3, confined = (1 - nu) / ((1 + nu) * (1 - 2 * nu));
  const double disc = BondedCylinderFactor(20, nu);
  EXPECT_LT(disc, confined);
  EXPECT_GT(disc, 0.97 * confined);
}

// The factor approaches that of an incompressible body continuously, without locking.
TEST(BondedCylinder, HasNoJumpAtIncompressibility) {
  EXPECT_NEAR(BondedCylinderFactor(1.6, 0.49999) / BondedCylinderFactor(1.6, 0.5), 1, 1e-3);
  EXPECT_GT(BondedCylinderFactor(1.6, 0.5), BondedCylinderFactor(1.6, 0.4));
}

TEST(BondedCylinder, RefusesWhatIsNone) {
  EXPECT_THROW(BondedCylinderFactor(0, 0.5), std::invalid_argument);
  EXPECT_THROW(BondedCylinderFactor(1, 0.6), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::identify
