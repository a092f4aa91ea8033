#include "slave/mechanics/fem/green/fem_green_model.h"

#include <array>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/mechanics/fem/solid/solid_model.h"
#include "slave/mechanics/mesh_resolution.h"
#include "tests/slave/mechanics/contacts.h"
#include "tests/slave/mechanics/direct_solution.h"
#include "tests/support/allocation_count.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using contacts::Answer;
using contacts::Move;
using contacts::Push;
using contacts::Respond;
using Eigen::Vector3d;
using Element = FemOptions::Element;

FemGreenModel ModelOf(const Body& body, FemGreenModel::Options options = {}) {
  options.range = 10;
  return FemGreenModel(body.mesh, body.held, body.E, body.nu, options);
}

// A box 0.1 m long, held at x = 0.
Body Beam(double thickness, int cells) {
  return Standing(MeshBox({0.1, thickness, thickness}, {cells, 2, 2}), 0, 5e4, 0.3);
}

// Fills the cache with all columns that contacts of a given width need.
void FillCache(const Body& body, const FemGreenModel::Options& options) {
  const auto stiffness = AssembleAtRest(body.mesh, body.held, body.nu, options.element);
  const CacheFilling filling = FillColumnCache(stiffness, options.width, options.cache, nullptr);
  ASSERT_EQ(filling.computed, filling.groups);
  ASSERT_EQ(FillColumnCache(stiffness, options.width, options.cache, nullptr).computed, 0U);
}

// Law: the answer is that of a model that computes everything itself. No factor is made, so no
// sparse solution is possible: a first contact on a slender body costs as much as a later one,
// apart from reading its columns.
TEST(FemGreenModel, ABodyFromAFullCacheNeedsNoFactor) {
  for (const double thickness : {0.08, 0.02}) {
    const Body body = Beam(thickness, 6);
    for (const Element element : {Element::kTet4, Element::kTet10}) {
      const Scratch scratch;
      const FemGreenModel::Options options{
          .element = element, .cache = scratch.path(), .width = 0.03};
      FillCache(body, options);
      FemGreenModel computed = ModelOf(body, {.element = element});
      FemGreenModel kept = ModelOf(body, options);
      bool bends = false;
      for (const double x : {0.02, 0.05, 0.09}) {
        for (const Vector3d& direction : {Vector3d(1, 0, 0), {0, 0, -1}}) {
          const Vector3d p_O(x, thickness / 2, thickness);
          const Contact press = Move(p_O, 1e-4 * direction, options.width);
          const ContactResponse expected = Answer(computed, press), got = Answer(kept, press);
          EXPECT_NE(expected.validity, Validity::kFailed) << computed.failure();
          EXPECT_EQ(got.force_O, expected.force_O);
          EXPECT_EQ(got.validity, expected.validity);
          EXPECT_EQ(got.flag_reason, expected.flag_reason);
          bends = bends || got.flag_reason == kStiffInBending;
        }
      }
      EXPECT_EQ(bends, thickness < 0.05 && element == Element::kTet4);
      EXPECT_FALSE(kept.columns().has_factor());
    }
  }
}

// Contacts with another width than the cache's are still answered.
TEST(FemGreenModel, TheCacheOfAnotherWidthIsNotTaken) {
  const Body body = Beam(0.02, 6);
  const Scratch scratch;
  FemGreenModel::Options options{.cache = scratch.path(), .width = 0.03};
  FillCache(body, options);
  options.width = 0;
  FemGreenModel other = ModelOf(body, options);
  EXPECT_TRUE(other.columns().has_factor()) << "not first at a contact";
  FemGreenModel computed = ModelOf(body);
  const Contact pull = Move(body.mesh.nodes.back(), {1e-4, 0, 0});
  EXPECT_EQ(Answer(other, pull).flag_reason, Answer(computed, pull).flag_reason);
}

// Law: an answer depends on the contact, not on earlier contacts.
TEST(FemGreenModel, TheFlagDoesNotDependOnEarlierContacts) {
  const Body body = Beam(0.02, 6);
  const Vector3d middle(0.1, 0.01, 0.01), rim(0.1, 0.002, 0.019);
  const std::vector<Contact> contacts{Move(middle, {-1e-5, 0, 0}, 0.04), Move(rim, {-1e-5, 0, 0}),
                                      Move(rim, {0, 0, -1e-5}, 0.01)};
  std::vector<std::string_view> expected;
  for (const Contact& contact : contacts) {
    FemGreenModel model = ModelOf(body);
    expected.push_back(Answer(model, contact).flag_reason);
  }
  FemGreenModel model = ModelOf(body);
  for (const std::size_t i : {2U, 1U, 0U, 1U, 2U, 0U}) {
    EXPECT_EQ(Answer(model, contacts[i]).flag_reason, expected[i]) << i;
  }
}

// The contacts are at new places, whose columns and bending are in the cache.
TEST(FemGreenModel, AFirstContactOnASlenderBodyTakesNoMemory) {
  const Body body = Beam(0.02, 6);
  const Scratch scratch;
  const FemGreenModel::Options options{.cache = scratch.path(), .width = 0.03};
  FillCache(body, options);
  FemGreenModel model = ModelOf(body, options);
  std::vector<int> all(static_cast<std::size_t>(model.columns().places()));
  std::iota(all.begin(), all.end(), 0);
  ASSERT_TRUE(model.columns().Prefetch(all, nullptr));
  const Vector3d down(0, 0, -1e-4);
  std::array<ContactResponse, 1> response;
  const Contact first = Move({0.25 / 3, 0.01, 0.02}, down, options.width);
  model.Respond({&first, 1}, response);
  const Contact second = Move({0.1 / 3, 0.01, 0.02}, down, options.width);
  model.Respond({&second, 1}, response);
  for (const double x : {0.2 / 3, 0.05}) {  // no more nodes under the tool
    const Contact next = Move({x, 0.01, 0.02}, down, options.width);
    const long before = AllocationCount();
    model.Respond({&next, 1}, response);
    EXPECT_EQ(AllocationCount(), before) << x;
    EXPECT_NE(response[0].validity, Validity::kFailed);
  }
}

TEST(FemGreenModel, FailsInWords) {
  const Body body = ShakenBox({4, 3, 3}, 5e4, 0.3);
  FemGreenModel model = ModelOf(body);
  const Vector3d top(0.06, 0.05, 0.04), floor(0, 0, 0), inside = body.mesh.nodes[26];
  const Vector3d d(1e-4, 0, 0);
  const std::vector<std::pair<std::vector<Contact>, std::string>> bad{
      {{Move({std::nan(""), 0, 0}, d)}, "not finite"},
      {{Move(top, {1e300, 0, 0})}, "too large"},
      {{Move({1, 1, 1}, d)}, "no surface"},
      {{Move(inside, d)}, "inside"},
      {{Push(floor, d)}, "fixed point"},
      {{Move(top, d, 0.02), Move(top, d)}, "overlap"},
      {{Move(top, d), Push(top, d)}, "completely under"}};
  for (const auto& [contacts, words] : bad) {
    EXPECT_EQ(Respond(model, contacts).front().validity, Validity::kFailed) << words;
    EXPECT_THAT(std::string(model.failure()), testing::HasSubstr(words));
  }
}

TEST(FemGreenModel, RefusesWhatCannotBeModelled) {
  const auto refusal = [](auto change) {
    Body body = ShakenBox({2, 2, 2}, 5e4, 0.3);
    change(&body);
    return Thrown<std::invalid_argument>([&] { ModelOf(body); });
  };
  using testing::HasSubstr;
  EXPECT_THAT(refusal([](Body* body) {  // slides and turns about z
                for (auto& held : body->held) held = {false, false, true};
              }),
              HasSubstr("free to move"));
  EXPECT_THAT(refusal([](Body* body) {  // a second part without supports
                const int first = static_cast<int>(body->mesh.nodes.size());
                body->mesh.nodes.insert(body->mesh.nodes.end(),
                                        {{1, 0, 0}, {2, 0, 0}, {1, 1, 0}, {1, 0, 1}});
                body->held.resize(body->held.size() + 4);
                body->mesh.tets.push_back({first, first + 1, first + 2, first + 3});
              }),
              HasSubstr("free to move"));
  EXPECT_THAT(refusal([](Body* body) { body->nu = 0.51; }), HasSubstr("poisson_ratio"));
  EXPECT_THAT(refusal([](Body* body) { body->mesh.tets[2][1] = 1000; }), HasSubstr("element 2"));
  EXPECT_THAT(refusal([](Body* body) { body->held.pop_back(); }), HasSubstr("fixed nodes"));
}

Body GreenCube(int cells, double nu) {
  return Standing(MeshBox({1, 1, 1}, {cells, cells, cells}), 2, 1, nu);
}

// The pressure is an unknown from nu = 0.4 on: the force on a cube between rough plates grows with
// nu by a third up to 0.5 (8 cells of ten nodes: 0.99, 1.02, 1.19, 1.20, 1.22 at these ratios), and
// a locking element's has no limit.
TEST(FemGreenLimits, NoElementLocks) {
  for (const Element element : {Element::kTet4, Element::kTet10}) {
    double first = 0;
    for (const double nu : {0.39, 0.4, 0.489, 0.499, 0.5}) {
      FemGreenModel model = ModelOf(GreenCube(4, nu), {.element = element});
      const ContactResponse answer = Answer(model, Move({0.5, 0.5, 1}, {0, 0, -1e-3}, 3));
      EXPECT_NE(answer.validity, Validity::kFailed) << nu;
      const double force = answer.force_O.norm();
      if (first == 0) first = force;
      EXPECT_LT(force, 1.4 * first) << nu;
      EXPECT_GT(force, 0.95 * first) << nu;
    }
  }
}

// Reference: `fem` with half of the edge length. The whole upper side is moved, bonded; the lower
// one is fixed.
TEST(FemGreenTenNodes, ForceOnAPressedCubeIsThatOfAFineMesh) {
  for (const double nu : {0.3, 0.49, 0.499, 0.5}) {
    FemGreenModel model = ModelOf(GreenCube(4, nu), {.element = Element::kTet10});
    SolidModel::Params params{
        .options = {.element = Element::kTet10, .law = FemOptions::Law::kLinear},
        .young_modulus = 1,
        .poisson_ratio = nu};
    const Body of_half_edges = GreenCube(8, nu);
    SolidModel fine(of_half_edges.mesh, of_half_edges.held, params);
    const Contact press = Move({0.5, 0.5, 1}, {0, 0, -1e-3}, 3);
    const ContactResponse is = Answer(model, press), should = Answer(fine, press);
    EXPECT_EQ(is.validity, Validity::kValid) << nu << " " << is.flag_reason;
    EXPECT_NEAR(is.force_O.z() / should.force_O.z(), 1, 0.02) << nu;
  }
}

}  // namespace
}  // namespace palpate
