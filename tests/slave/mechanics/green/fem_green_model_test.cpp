#include "slave/mechanics/fem/green/fem_green_model.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/fem/solid/solid_model.h"
#include "tests/slave/mechanics/contacts.h"
#include "tests/slave/mechanics/direct_solution.h"
#include "tests/support/allocation_count.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using contacts::Move;
using contacts::Push;
using contacts::Respond;
using Eigen::Vector3d;
using Element = FemOptions::Element;

FemGreenModel ModelOf(const Body& body, FemGreenModel::Options options = {}) {
  options.range = 10;
  return FemGreenModel(body.mesh, body.held, body.E, body.nu, options);
}

// Nodes, points inside triangles and discs far from the support, on every side; several kinds
// together, as wide as the meshes follow. `side` scales the displacements.
std::vector<Contact> Mixed(const Body& body) {
  const SurfaceMesh surface = SurfaceOf(body.mesh);
  const double side = Diagonal(body.mesh.nodes);
  std::vector<int> far;  // triangles, well apart, away from what is held
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    bool apart = true;
    for (std::size_t n = 0; n < body.held.size(); ++n) {
      const bool near = (Centroid(surface, t) - body.mesh.nodes[n]).norm() < 0.2 * side;
      apart = apart && !(near && body.held[n][0]);
    }
    for (const int other : far) {
      apart = apart && (Centroid(surface, t) - Centroid(surface, other)).norm() > 0.25 * side;
    }
    if (apart) far.push_back(t);
  }
  const auto node = [&](std::size_t k) {
    return surface
        .nodes[static_cast<std::size_t>(surface.triangles[static_cast<std::size_t>(far.at(k))][0])];
  };
  return {Move(node(0), {0.01 * side, -0.005 * side, 0.004 * side}),
          Push(Centroid(surface, far.at(1)), {0.02, 0.01, -0.03}, 0.2 * side),
          Move(0.9 * Centroid(surface, far.at(2)) + 0.1 * node(2), {0, 0.004 * side, -0.01 * side}),
          Push(node(3), {-0.01, 0.02, 0.005}),
          Move(node(4), {-0.01 * side, 0.002 * side, 0.003 * side}, 0.25 * side)};
}

void ExpectSame(const std::vector<Contact>& contacts, const std::vector<ContactResponse>& got,
                const DirectAnswer& direct, double tolerance) {
  double force = 0, moved = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    force = std::max({force, direct.force_O[i].norm(), got[i].force_O.norm()});
    moved = std::max(moved, direct.mean_O[i].norm());
  }
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    ASSERT_TRUE(got[i].validity != Validity::kFailed) << "contact " << i;
    if (contacts[i].kind == Contact::Kind::kDisplacement) {
      EXPECT_LT((got[i].force_O - direct.force_O[i]).norm(), tolerance * force) << "contact " << i;
    } else {
      EXPECT_LT((got[i].displacement_O - direct.mean_O[i]).norm(), tolerance * moved)
          << "contact " << i;
    }
  }
}

void ExpectSameField(FemGreenModel& model, const std::vector<Contact>& contacts,
                     const DirectAnswer& direct, double tolerance) {
  Solution solution;
  model.Solve(contacts, &solution);
  Respond(model, {contacts.front()});  // other queries do not count
  std::vector<Vector3d> field;
  model.Displacements(solution, &field);
  ASSERT_EQ(field.size(), direct.displacement_O.size());
  double largest = 0;
  for (const auto& u : direct.displacement_O) largest = std::max(largest, u.norm());
  for (std::size_t n = 0; n < field.size(); ++n) {
    EXPECT_LT((field[n] - direct.displacement_O[n]).norm(), tolerance * largest) << "node " << n;
  }
}

// Reference: the same finite elements in another formulation (direct_solution.h). Both solve the
// same equations with condition numbers below 1e6: 1e-9 leaves three digits.
class FemGreenAgainstDirect : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const std::string name = GetParam();
    if (name == "box") {
      body_ = ShakenBox({4, 3, 4}, 5e4, 0.3);
      return;
    }
    const SolidMesh mesh = FoamMesh(name);
    if (mesh.nodes.empty()) GTEST_SKIP() << "../shared is not there";
    body_ = Standing(mesh, 0, 3800, 0.15);
  }
  Body body_;
};

TEST_P(FemGreenAgainstDirect, NodesPointsPatchesAndLoadsTogetherAgree) {
  FemGreenModel model = ModelOf(body_);
  const auto all = Mixed(body_);
  for (std::size_t i = 0; i <= all.size(); ++i) {  // each alone, then together
    const auto contacts = i < all.size() ? std::vector<Contact>{all[i]} : all;
    const DirectAnswer direct = SolveDirectly(body_, contacts, false);
    ExpectSame(contacts, Respond(model, contacts), direct, 1e-9);
    ExpectSameField(model, contacts, direct, 1e-9);
  }
}

TEST_P(FemGreenAgainstDirect, FrictionlessContactsAgree) {
  FemGreenModel model = ModelOf(body_, {.contact = ContactLaw::kFrictionless});
  auto contacts = Mixed(body_);
  contacts.erase(contacts.begin() + 2);  // points between nodes have no node's normal
  const DirectAnswer direct = SolveDirectly(body_, contacts, true);
  ExpectSame(contacts, Respond(model, contacts), direct, 1e-9);
  ExpectSameField(model, contacts, direct, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Bodies, FemGreenAgainstDirect,
                         testing::Values("box", "cube", "bar", "sponge"),
                         [](const auto& body) { return std::string(body.param); });

TEST(FemGreenModel, AllocatesNothingOnceSizesWereSeen) {
  const Body body = ShakenBox({5, 4, 4}, 5e4, 0.3);
  FemGreenModel model = ModelOf(body);
  ASSERT_TRUE(model.PrefetchNodes());
  std::vector<std::vector<Contact>> sets;
  for (int turn = 0; turn < 4; ++turn) {
    auto contacts = Mixed(body);
    const SurfaceMesh& surface = model.surface();
    for (std::size_t t = 20; t < surface.triangles.size() && contacts.size() < 14; t += 7) {
      const Vector3d p = Centroid(surface, static_cast<int>(t)) +
                         1e-4 * turn * Normal(surface, static_cast<int>(t));
      if (p.z() < 0.012 || (p - contacts[4].p_O).norm() < 0.04) continue;
      contacts.push_back(Move(p, {1e-4, 0, 0}));
    }
    if (turn % 2 == 1) std::swap(contacts[0], contacts[3]);
    sets.push_back(contacts);
  }
  std::vector<ContactResponse> responses(sets[0].size());
  for (const auto& set : sets) {
    model.Respond(set, responses);
    ASSERT_NE(responses[0].validity, Validity::kFailed) << model.failure();
  }
  const long before = AllocationCount();
  for (int i = 0; i < 40; ++i) {
    auto& set = sets[static_cast<std::size_t>(i % 4)];
    set[2].prescribed_O *= 1.01;
    model.Respond(set, responses);
    const std::size_t fewer = set.size() - static_cast<std::size_t>(i % 3);
    model.Respond({set.data(), fewer}, {responses.data(), fewer});
  }
  EXPECT_EQ(AllocationCount() - before, 0);
}

// A slender body needs the factor to see whether it bends.
TEST(FemGreenModel, ABulkyBodyFromAFullCacheNeedsNoFactor) {
  for (const bool bulky : {true, false}) {
    const double thick = bulky ? 0.08 : 0.02;  // of 0.1 m
    const Body body = Standing(MeshBox({0.1, thick, thick}, {6, 2, 2}), 0, 5e4, 0.3);
    const Scratch scratch;
    const FemGreenModel::Options options{.cache = scratch.path()};
    FemGreenModel computed = ModelOf(body, options);
    ASSERT_TRUE(computed.PrefetchNodes());
    FemGreenModel kept = ModelOf(body, options);
    const auto contacts = std::vector{Move(body.mesh.nodes.back(), {1e-4, 0, 0})};
    const auto expected = Respond(computed, contacts), got = Respond(kept, contacts);
    EXPECT_EQ(got[0].force_O, expected[0].force_O);
    EXPECT_EQ(got[0].validity, expected[0].validity);
    EXPECT_EQ(kept.columns().has_factor(), !bulky);
  }
}

// Everything that cannot be answered is refused with a reason, and the next good question is
// answered as if nothing had been.
TEST(FemGreenModel, FailsInWordsAndRecovers) {
  const Body body = ShakenBox({4, 3, 3}, 5e4, 0.3);
  FemGreenModel model = ModelOf(body);
  const auto good = Mixed(body);
  const auto reference = Respond(model, good);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Vector3d top(0.06, 0.05, 0.04), floor(0, 0, 0), inside = body.mesh.nodes[26];
  const Vector3d d(1e-4, 0, 0);
  const std::vector<std::pair<std::vector<Contact>, std::string>> bad{
      {{Move({nan, 0, 0}, d)}, "not finite"},
      {{Move(top, {1e300, 0, 0})}, "too large"},
      {{Push(top, {0, nan, 0})}, "not finite"},
      {{Move(top, d, -1)}, "not finite"},
      {{Move({1, 1, 1}, d)}, "no surface"},
      {{Move(inside, d)}, "inside"},
      {{Move(floor, d)}, "fixed point"},
      {{Push(floor, d)}, "fixed point"},
      {{Move(top, d), Move(top, d)}, "overlap"},
      {{Move(top, d, 0.02), Move(top, d)}, "overlap"},
      {{Move(top, d), Push(top, d)}, "completely under"},
      {{Move({0.059, 0.0495, 0.04}, d), Move({0.059, 0.0495, 0.04}, d)}, "overlap"},
  };
  for (std::size_t k = 0; k < bad.size(); ++k) {
    for (const auto& response : Respond(model, bad[k].first)) {
      EXPECT_EQ(response.validity, Validity::kFailed) << "case " << k;
      EXPECT_TRUE(response.force_O.isZero(0));
    }
    EXPECT_THAT(std::string(model.failure()), testing::HasSubstr(bad[k].second)) << "case " << k;
    const auto again = Respond(model, good);
    for (std::size_t i = 0; i < again.size(); ++i) {
      EXPECT_EQ(again[i].force_O, reference[i].force_O) << "after case " << k;
    }
  }
  Contact wrong = good[0];
  wrong.element = 1 << 20;
  EXPECT_EQ(Respond(model, {wrong})[0].validity, Validity::kFailed);
}

TEST(FemGreenModel, RefusesWhatCannotBeModelled) {
  const Body good = ShakenBox({2, 2, 2}, 5e4, 0.3);
  const auto expect = [](const Body& body, const char* word) {
    EXPECT_THAT(Thrown<std::invalid_argument>([&] { ModelOf(body); }), testing::HasSubstr(word));
  };
  Body body = good;
  for (auto& held : body.held) held = {false, false, false};
  expect(body, "free to move");
  for (auto& held : body.held) held = {false, false, true};  // slides and turns about z
  expect(body, "free to move");
  body = good;
  body.mesh.nodes.insert(body.mesh.nodes.end(), {{1, 0, 0}, {2, 0, 0}, {1, 1, 0}, {1, 0, 1}});
  body.held.resize(body.held.size() + 4);
  const int first = static_cast<int>(good.mesh.nodes.size());
  body.mesh.tets.push_back({first, first + 1, first + 2, first + 3});
  expect(body, "free to move");  // a second part that nothing holds
  body = good;
  body.nu = 0.5;  // of four nodes
  expect(body, "poisson_ratio");
  body.nu = std::numeric_limits<double>::quiet_NaN();
  expect(body, "poisson_ratio");
  body = good;
  body.E = -1;
  expect(body, "young_modulus");
  body = good;
  std::swap(body.mesh.tets[3][0], body.mesh.tets[3][1]);
  expect(body, "tetrahedron 3");
  body = good;
  body.mesh.tets[2][1] = 1000;
  expect(body, "element 2");
  body = good;
  body.held.pop_back();
  expect(body, "fixed nodes");
}

TEST(FemGreenModel, FlagsDisplacementsBeyondItsRange) {
  const Body body = ShakenBox({2, 2, 2}, 5e4, 0.3);
  FemGreenModel model(body.mesh, body.held, body.E, body.nu, {.range = 0.1});
  const Vector3d top(0.06, 0.05, 0.04);
  EXPECT_EQ(Respond(model, {Move(top, {0.0059, 0, 0})})[0].validity, Validity::kValid);
  EXPECT_EQ(Respond(model, {Move(top, {0.0061, 0, 0})})[0].validity, Validity::kExtrapolated);
}

Body Cube(double nu) {
  return Standing(MeshBox({1, 1, 1}, {2, 2, 2}), 2, 1, nu);
}

// Linear tetrahedra are known to lock from nu = 0.49 on; quadratic ones have a pressure from there.
TEST(FemGreenLimits, LockingIsFlagged) {
  for (const Element element : {Element::kTet4, Element::kTet10}) {
    for (const double nu : {0.489, 0.49, 0.499}) {
      FemGreenModel model = ModelOf(Cube(nu), {.element = element});
      const auto answer = Respond(model, {Move({1, 1, 1}, {0, 0, -1e-3})});
      const bool locks = element == Element::kTet4 && nu >= 0.49;
      EXPECT_EQ(answer[0].validity, locks ? Validity::kExtrapolated : Validity::kValid) << nu;
    }
  }
}

// The model of the same equations that solves for all nodes of the mesh at each contact.
SolidModel WholeBody(const Body& body) {
  SolidModel::Params params;
  params.options.element = Element::kTet10;
  params.options.law = FemOptions::Law::kLinear;
  params.options.residual = 1e-10;
  params.young_modulus = body.E;
  params.poisson_ratio = body.nu;
  params.range = 10;
  return SolidModel(body.mesh, body.held, params);
}

class FemGreenTenNodes : public testing::TestWithParam<double> {};

// Reference: `fem` with the same elements, pressure included. Corners, middles of edges, discs and
// loads, each alone and all together.
TEST_P(FemGreenTenNodes, AgreeWithTheWholeBody) {
  const Body body = ShakenBox({4, 3, 3}, 5e4, GetParam());
  FemGreenModel model = ModelOf(body, {.element = Element::kTet10});
  SolidModel whole = WholeBody(body);
  const std::vector<Contact> all{
      Move({0.06, 0.05, 0.04}, {1e-4, -2e-4, -3e-4}), Move({0, 0.05 / 6, 0.04}, {0, 1e-4, -2e-4}),
      Move({0.04, 0.018, 0.04}, {1e-4, 0, -5e-4}, 0.03),
      Push({0.015, 0.035, 0.04}, {0.02, 0.01, -0.05}, 0.02), Push({0.06, 0, 0.04}, {0, 0.01, 0})};
  for (std::size_t i = 0; i <= all.size(); ++i) {
    const auto contacts = i < all.size() ? std::vector<Contact>{all[i]} : all;
    Solution solution, reference;
    model.Solve(contacts, &solution);
    whole.Solve(contacts, &reference);
    DirectAnswer direct;
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      direct.force_O.push_back(reference.responses()[k].force_O);
      direct.mean_O.push_back(reference.responses()[k].displacement_O);
    }
    whole.Displacements(reference, &direct.displacement_O);
    ExpectSame(contacts, solution.responses(), direct, 1e-8);
    ExpectSameField(model, contacts, direct, 1e-8);
  }
}

// Law: without friction there is no traction across the normal, so that a slanted displacement does
// what its part along the normal does. A corner node, the middle of an edge and a disc on the top.
TEST_P(FemGreenTenNodes, FrictionlessContactsPushAlongTheNormal) {
  const Body body = ShakenBox({4, 3, 3}, 5e4, GetParam());
  FemGreenModel model =
      ModelOf(body, {.element = Element::kTet10, .contact = ContactLaw::kFrictionless});
  const SurfaceMesh surface = SurfaceOf(body.mesh);
  const auto on_top = std::ranges::find_if(surface.triangles, [&](const auto& triangle) {
    return std::ranges::all_of(triangle, [&](int n) {
      const Vector3d& p = surface.nodes[static_cast<std::size_t>(n)];
      const bool within = p.x() > 1e-9 && p.x() < 0.04 && p.y() > 1e-9 && p.y() < 0.05 - 1e-9;
      return within && p.z() > 0.04 - 1e-9;
    });
  });
  ASSERT_NE(on_top, surface.triangles.end());
  const Vector3d& corner = surface.nodes[static_cast<std::size_t>((*on_top)[0])];
  const Vector3d middle = 0.5 * (corner + surface.nodes[static_cast<std::size_t>((*on_top)[1])]);
  const Vector3d disc(0.045, 0.025, 0.04);
  const auto press = [&](double across) {
    const Vector3d by(across, 0, -1e-3);
    return Respond(model, {Move(corner, by), Move(middle, by), Move(disc, by, 0.016)});
  };
  const auto straight = press(0), slanted = press(2e-3);
  for (std::size_t i = 0; i < straight.size(); ++i) {
    ASSERT_NE(straight[i].validity, Validity::kFailed) << model.failure();
    const Vector3d force = straight[i].force_O;
    EXPECT_GT(force.norm(), 0) << i;
    EXPECT_LT(force.head<2>().norm(), 1e-6 * force.norm()) << i;
    EXPECT_LT((slanted[i].force_O - force).norm(), 1e-9 * force.norm()) << i;
  }
}

// Reference: `fem` with half of the edge length. The whole upper side is moved, bonded; the lower
// one is fixed.
TEST_P(FemGreenTenNodes, ForceOnAPressedCubeIsThatOfAFineMesh) {
  const auto cube = [](int cells) {
    return Standing(MeshBox({1, 1, 1}, {cells, cells, cells}), 2, 1, GetParam());
  };
  FemGreenModel model = ModelOf(cube(4), {.element = Element::kTet10});
  SolidModel fine = WholeBody(cube(8));
  const std::vector<Contact> press{Move({0.5, 0.5, 1}, {0, 0, -1e-3}, 3)};
  const ContactResponse is = Respond(model, press)[0], should = Respond(fine, press)[0];
  EXPECT_EQ(is.validity, Validity::kValid) << is.doubt;
  EXPECT_NEAR(is.force_O.z() / should.force_O.z(), 1, 0.02);
}

INSTANTIATE_TEST_SUITE_P(PoissonRatios, FemGreenTenNodes, testing::Values(0.3, 0.49, 0.499, 0.5));

}  // namespace
}  // namespace palpate
