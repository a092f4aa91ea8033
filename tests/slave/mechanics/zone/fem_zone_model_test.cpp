// The model `fem-zone` against the full model of the same mesh, and what it flags and refuses.
#include "slave/mechanics/fem/zone/fem_zone_model.h"

#include <limits>

#include <gtest/gtest.h>

#include "slave/mechanics/mesh_resolution.h"
#include "tests/slave/mechanics/contacts.h"
#include "tests/slave/mechanics/zone/pressed_slab.h"

namespace palpate {
namespace {

using contacts::Respond;
using namespace zone_tests;  // NOLINT(google-build-using-namespace): its helpers are for here

constexpr double kWidth = 0.02;  // of every disc [m]

Contact Pressed(const Vector3d& p_O, const Vector3d& displacement_O, double width = kWidth) {
  return contacts::Move(p_O, displacement_O, width);
}

class FemZone : public testing::Test {
 protected:
  Slab slab_{10, 0.4};
  FemZoneModel zone_{slab_.mesh, slab_.held, kModulus, slab_.nu, {}};
};

// Discs, a node, a point inside a triangle, pressed deep. Alone they are within 3 %; together,
// where neighbours leave each other small zones, within the tolerance of 5 %. A mesh too coarse for
// a disc is flagged as the full model flags it, and several contacts at once are. The true error is
// within the bound that the answer states; alone, where no neighbour adds to it, the bound is
// within five times the error.
TEST_F(FemZone, ForcesAreThoseOfTheFullModelWithinTheirBound) {
  SolidModel full = slab_.Full(FemOptions::Law::kNeoHookean);
  const std::vector<Contact> all{Pressed({0.018, 0.02, 0.04}, {0.001, 0, -0.005}),
                                 Pressed({0.062, 0.02, 0.04}, {0, 0.002, -0.006}),
                                 Pressed({0.056, 0.064, 0.04}, {0, 0, -0.002}, 0),
                                 Pressed({0.0181, 0.0617, 0.04}, {0, 0, -0.002}, 0)};
  std::vector<std::vector<Contact>> cases{all};
  for (const Contact& contact : all) cases.push_back({contact});
  for (const auto& contacts : cases) {
    const auto expected = Respond(full, contacts);
    const auto got = Respond(zone_, contacts);
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      ASSERT_NE(got[i].validity, Validity::kFailed) << zone_.failure();
      const double error = (got[i].force_O - expected[i].force_O).norm();
      const bool alone = contacts.size() == 1;
      EXPECT_EQ(got[i].validity, alone ? expected[i].validity : Validity::kExtrapolated)
          << got[i].doubt;
      EXPECT_LT(error, (contacts.size() == 1 ? 0.03 : 0.05) * expected[i].force_O.norm());
      EXPECT_LE(error, got[i].force_error);
      if (contacts.size() == 1) EXPECT_LT(got[i].force_error, 5 * error);
    }
  }
}

TEST_F(FemZone, LoadsMoveTheBodyAsTheyMoveTheFullModel) {
  SolidModel full = slab_.Full(FemOptions::Law::kNeoHookean);
  Contact load = Pressed({0.04, 0.04, 0.04}, {0.1, 0, -0.5});
  load.kind = Contact::Kind::kForce;
  const auto expected = Respond(full, {load}), got = Respond(zone_, {load});
  const double error = (got[0].displacement_O - expected[0].displacement_O).norm();
  EXPECT_GT(expected[0].displacement_O.norm(), 0.1 * kWidth);
  EXPECT_LT(error, 0.03 * expected[0].displacement_O.norm());
  EXPECT_LE(error, got[0].displacement_error);
  EXPECT_EQ(got[0].force_O, load.prescribed_O);
}

// The whole displacement, near and far: within the tolerance of the largest.
TEST_F(FemZone, DisplacementsAreThoseOfTheFullModel) {
  SolidModel full = slab_.Full(FemOptions::Law::kNeoHookean);
  const std::vector<Contact> contacts{Pressed({0.02, 0.024, 0.04}, {0.001, 0, -0.005}),
                                      Pressed({0.052, 0.024, 0.04}, {0, 0.002, -0.006})};
  Solution solution, reference;
  zone_.Solve(contacts, &solution);
  full.Solve(contacts, &reference);
  std::vector<Vector3d> u, expected;
  zone_.Displacements(solution, &u);
  full.Displacements(reference, &expected);
  ASSERT_EQ(u.size(), expected.size());
  double largest = 0;
  for (std::size_t n = 0; n < u.size(); ++n) {
    largest = std::max(largest, (u[n] - expected[n]).norm());
  }
  EXPECT_LT(largest, 0.05 * 0.0064);
}

// A stiff layer below the contact, and a stiff lump beside it.
TEST_F(FemZone, RegionsHaveTheirModuli) {
  Slab layered(10, 0.4);
  for (const auto& tet : layered.mesh.tets) {
    Vector3d centroid = Vector3d::Zero();
    for (const int node : tet) centroid += layered.mesh.nodes[Index(node)] / 4;
    const bool lump = (centroid - Vector3d(0.055, 0.04, 0.03)).norm() < 0.012;
    layered.mesh.modulus.push_back(lump ? 5 : (centroid.z() < 0.016 ? 3 : 1));
  }
  FemZoneModel zone(layered.mesh, layered.held, kModulus, layered.nu, {});
  SolidModel full = layered.Full(FemOptions::Law::kNeoHookean);
  const std::vector<Contact> contacts{Pressed({0.044, 0.04, 0.04}, {0.001, 0, -0.005})};
  const auto expected = Respond(full, contacts)[0], got = Respond(zone, contacts)[0];
  const double error = (got.force_O - expected.force_O).norm();
  EXPECT_LE(error, got.force_error);
  EXPECT_LT(error, 0.03 * expected.force_O.norm());
  EXPECT_GT(expected.force_O.norm(), 1.1 * Respond(zone_, contacts)[0].force_O.norm());
}

// A slender slab on one side turns as a whole when it is pressed: the zone does not follow that.
TEST(FemZoneLimits, ABodyThatBendsFarIsFlaggedOrItsErrorIsBounded) {
  Slab slab(12, 0.4);
  slab.mesh = MeshBox({0.08, 0.08, 0.02}, {12, 12, 3});
  slab.held = FixedWhere(slab.mesh, [](const Vector3d& p) { return p.x() == 0; });
  slab.positions.clear();
  for (const Vector3d& p : slab.mesh.nodes) slab.positions.push_back(p / 0.08);
  FemZoneModel zone(slab.mesh, slab.held, kModulus, slab.nu, {});
  SolidModel full = slab.Full(FemOptions::Law::kNeoHookean);
  for (const double depth : {0.001, 0.004, 0.012, 0.03}) {
    const std::vector<Contact> contacts{Pressed({0.07, 0.04, 0.02}, {0, 0, -depth})};
    const auto expected = Respond(full, contacts), got = Respond(zone, contacts);
    if (got[0].validity != Validity::kValid) continue;
    const double error = (got[0].force_O - expected[0].force_O).norm();
    EXPECT_LE(error, got[0].force_error);
    EXPECT_LE(error, 0.05 * expected[0].force_O.norm());
  }
  EXPECT_NE(Respond(zone, {Pressed({0.07, 0.04, 0.02}, {0, 0, -0.03})})[0].validity,
            Validity::kValid);
}

// How the body bends is learned once per place: the flag is that of a model that learned it anew.
TEST(FemZoneLimits, ANearbyContactBendsTheBodyAlike) {
  Slab slab(12, 0.4);
  slab.mesh = MeshBox({0.12, 0.03, 0.01}, {24, 6, 2});
  slab.held = FixedWhere(slab.mesh, [](const Vector3d& p) { return p.x() == 0; });
  FemZoneModel zone(slab.mesh, slab.held, kModulus, slab.nu, {});
  bool bends = false;
  for (const double x : {0.005, 0.03, 0.06, 0.1}) {
    Respond(zone, {Pressed({x, 0.015, 0.01}, {0, 0, -1e-5}, 0.015)});
    const Contact beside = Pressed({x + 0.0035, 0.015, 0.01}, {0, 0, -1e-5}, 0.015);
    FemZoneModel fresh(slab.mesh, slab.held, kModulus, slab.nu, {});
    const auto got = Respond(zone, {beside}), expected = Respond(fresh, {beside});
    EXPECT_EQ(got[0].doubt, expected[0].doubt) << x;
    bends = bends || got[0].doubt == kStiffInBending;
  }
  EXPECT_TRUE(bends);
}

// A body as small as its zone is nonlinear everywhere: the full model.
TEST(FemZoneLimits, ABodyWithinOneZoneIsTheFullModel) {
  Slab slab(10, 0.3);
  slab.mesh = MeshBox({0.01, 0.01, 0.01}, {4, 4, 4});
  slab.held = FixedWhere(slab.mesh, [](const Vector3d& p) { return p.z() == 0; });
  FemZoneModel zone(slab.mesh, slab.held, kModulus, slab.nu, {});
  SolidModel full = slab.Full(FemOptions::Law::kNeoHookean);
  const std::vector<Contact> contacts{Pressed({0.005, 0.005, 0.01}, {0, 0, -0.002}, 0.03)};
  const Vector3d expected = Respond(full, contacts)[0].force_O;
  EXPECT_LT((Respond(zone, contacts)[0].force_O - expected).norm(), 1e-4 * expected.norm());
}

}  // namespace
}  // namespace palpate
