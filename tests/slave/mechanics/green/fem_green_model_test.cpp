#include "slave/mechanics/fem/green/fem_green_model.h"

#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/mechanics/fem/solid/solid_model.h"
#include "tests/slave/mechanics/contacts.h"
#include "tests/slave/mechanics/direct_solution.h"
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

// A slender body needs the factor to see whether it bends.
TEST(FemGreenModel, ABulkyBodyFromAFullCacheNeedsNoFactor) {
  for (const bool bulky : {true, false}) {
    const double thick = bulky ? 0.08 : 0.02;  // of 0.1 m
    const Body body = Standing(MeshBox({0.1, thick, thick}, {6, 2, 2}), 0, 5e4, 0.3);
    const Scratch scratch;
    const FemGreenModel::Options options{.cache = scratch.path()};
    FemGreenModel computed = ModelOf(body, options);
    std::vector<int> all(static_cast<std::size_t>(computed.columns().places()));
    std::iota(all.begin(), all.end(), 0);
    ASSERT_TRUE(computed.columns().Prefetch(all, nullptr));
    FemGreenModel kept = ModelOf(body, options);
    EXPECT_EQ(kept.columns().has_factor(), !bulky) << "not first at a contact";
    const Contact pull = Move(body.mesh.nodes.back(), {1e-4, 0, 0});
    const ContactResponse expected = Answer(computed, pull), got = Answer(kept, pull);
    EXPECT_EQ(got.force_O, expected.force_O);
    EXPECT_EQ(got.validity, expected.validity);
    EXPECT_EQ(kept.columns().has_factor(), !bulky);
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
  EXPECT_THAT(refusal([](Body* body) {  // a second part that nothing holds
                const int first = static_cast<int>(body->mesh.nodes.size());
                body->mesh.nodes.insert(body->mesh.nodes.end(),
                                        {{1, 0, 0}, {2, 0, 0}, {1, 1, 0}, {1, 0, 1}});
                body->held.resize(body->held.size() + 4);
                body->mesh.tets.push_back({first, first + 1, first + 2, first + 3});
              }),
              HasSubstr("free to move"));
  EXPECT_THAT(refusal([](Body* body) { body->nu = 0.5; }), HasSubstr("poisson_ratio"));
  EXPECT_THAT(refusal([](Body* body) { body->mesh.tets[2][1] = 1000; }), HasSubstr("element 2"));
  EXPECT_THAT(refusal([](Body* body) { body->held.pop_back(); }), HasSubstr("fixed nodes"));
}

Body Cube(int cells, double nu) {
  return Standing(MeshBox({1, 1, 1}, {cells, cells, cells}), 2, 1, nu);
}

// Linear tetrahedra are known to lock from nu = 0.49 on; quadratic ones have a pressure from there.
TEST(FemGreenLimits, LockingIsFlagged) {
  for (const Element element : {Element::kTet4, Element::kTet10}) {
    for (const double nu : {0.489, 0.49, 0.499}) {
      FemGreenModel model = ModelOf(Cube(2, nu), {.element = element});
      const ContactResponse answer = Answer(model, Move({1, 1, 1}, {0, 0, -1e-3}));
      const bool locks = element == Element::kTet4 && nu >= 0.49;
      EXPECT_EQ(answer.validity, locks ? Validity::kExtrapolated : Validity::kValid) << nu;
    }
  }
}

// Reference: `fem` with half of the edge length. The whole upper side is moved, bonded; the lower
// one is fixed.
TEST(FemGreenTenNodes, ForceOnAPressedCubeIsThatOfAFineMesh) {
  for (const double nu : {0.3, 0.49, 0.499, 0.5}) {
    FemGreenModel model = ModelOf(Cube(4, nu), {.element = Element::kTet10});
    SolidModel::Params params{
        .options = {.element = Element::kTet10, .law = FemOptions::Law::kLinear},
        .young_modulus = 1,
        .poisson_ratio = nu};
    const Body of_half_edges = Cube(8, nu);
    SolidModel fine(of_half_edges.mesh, of_half_edges.held, params);
    const Contact press = Move({0.5, 0.5, 1}, {0, 0, -1e-3}, 3);
    const ContactResponse is = Answer(model, press), should = Answer(fine, press);
    EXPECT_EQ(is.validity, Validity::kValid) << nu << " " << is.doubt;
    EXPECT_NEAR(is.force_O.z() / should.force_O.z(), 1, 0.02) << nu;
  }
}

}  // namespace
}  // namespace palpate
