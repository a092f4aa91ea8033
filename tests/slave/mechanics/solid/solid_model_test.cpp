// Compares SolidModel with discrete reference solutions, and tests its requirements as a model.
#include "slave/mechanics/fem/solid/solid_model.h"

#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/mechanics/solid/bodies.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using namespace solid_tests;  // NOLINT(google-build-using-namespace): its helpers are for here
using Eigen::Vector3d;

// The mid-edge nodes under a tool have its displacement, and no others. Its
// load is distributed over its triangles, with none at the corners of ten-node elements.
TEST(SolidModel, PatchesFollowTheContract) {
  const SolidMesh mesh = MeshBox({1, 1, 1}, {4, 4, 4});
  auto params = Foam(Element::kTet10, Law::kLinear);
  SolidModel model(mesh, Bottom(mesh), params);
  const Vector3d down(0, 0, -0.01), p(0.5, 0.5, 1);
  Answer(model, Move(p, down, 0.6));
  int alike = 0;
  for (int i = 0; i < model.mesh().node_count(); ++i) {
    const Vector3d at = model.mesh().nodes[static_cast<std::size_t>(i)];
    const bool is_middle = i >= static_cast<int>(mesh.nodes.size());
    const bool inside = is_middle && (at - p).norm() <= 0.3 + 1e-9 && at.z() == 1;
    EXPECT_EQ((model.displacement(i) - down).norm() < 1e-15, inside) << at.transpose();
    alike += inside;
  }
  EXPECT_EQ(alike, 16);  // of a grid of 1/8, within 0.3 of one of its points: 21, less 5 corners
  VolumeContacts set(mesh, 10, Nothing(mesh), 1, 1);
  const Contact push = Push(p, down, 0.6);
  ASSERT_TRUE(set.Prepare({&push, 1}));
  double sum = 0;
  for (const auto& [node, share] : set.places()[0].nodes) {
    EXPECT_GE(node, model.mesh().vertex_count);
    EXPECT_GT(share, 0);
    sum += share;
  }
  EXPECT_NEAR(sum, 1, 1e-14);
}

// Balanced loads on a body without supports: the bar stretches by F L / (E A) about its centre,
// without mean motion. Unbalanced loads are refused.
TEST(SolidModel, FreeBodiesTakeBalancedLoadsOnly) {
  const SolidMesh mesh = MeshBox({4, 1, 1}, {8, 2, 2});
  for (const Law law : {Law::kLinear, Law::kNeoHookean}) {
    auto params = Foam(Element::kTet10, law);
    params.poisson_ratio = 0;
    params.young_modulus = 1000;
    SolidModel model(mesh, Nothing(mesh), params);
    std::vector<Contact> pull;
    for (const double x : {0.0, 4.0}) {
      pull.push_back(Push({x, 0.5, 0.5}, {x > 0 ? 0.1 : -0.1, 0, 0}, 1.6));  // the whole end
    }
    std::vector<ContactResponse> responses(2);
    model.Respond(pull, responses);
    ASSERT_EQ(responses[0].validity, Validity::kValid) << model.failure();
    EXPECT_NEAR(responses[1].displacement_O.x(), 0.5 * 0.1 * 4 / 1000, 1e-6);
    EXPECT_NEAR((responses[0].displacement_O + responses[1].displacement_O).norm(), 0, 1e-6);
    pull.pop_back();
    responses.pop_back();
    model.Respond(pull, responses);
    EXPECT_EQ(responses[0].validity, Validity::kFailed);
    EXPECT_NE(model.failure().find("do not balance"), std::string::npos);
  }
}

TEST(SolidModel, RefusesWhatItCannotDo) {
  using P = SolidModel::Params;
  const std::vector<std::pair<void (*)(P*), const char*>> mistakes{
      {[](P* p) { p->poisson_ratio = 0.51; }, "poisson_ratio = 0.51"},
      {[](P* p) { p->options.element = Element::kTet4, p->poisson_ratio = 0.5; }, "0.49999"},
      {[](P* p) { p->options.law = Law::kNeoHookean, p->poisson_ratio = 0.5; }, "law = linear"},
      {[](P* p) { p->density = 0, p->options.time = FemOptions::Time::kDynamic; }, "density"},
      {[](P* p) { p->options.time = FemOptions::Time::kDynamic, p->options.step = -1; },
       "step = -1"},
      {[](P* p) { p->options.residual = 0; }, "residual"}};
  const SolidMesh mesh = MeshBox({1, 1, 1}, {1, 1, 1});
  for (const auto& [change, word] : mistakes) {
    auto params = Foam(Element::kTet10, Law::kLinear);
    change(&params);
    EXPECT_THAT(
        Thrown<std::invalid_argument>([&] { const SolidModel model(mesh, Bottom(mesh), params); }),
        testing::HasSubstr(word));
  }
}

// The equilibria with and without a factor are the same, although the search passes unstable
// states: a corner pressed flat, and a point pulled so far that parts of the tangent become
// indefinite.
TEST(SolidModel, IterationsComeThroughIndefiniteTangents) {
  const SolidMesh mesh = MeshBox({1, 1, 1}, {5, 5, 5});
  for (const auto& [law, element] : {std::pair{Law::kLinear, Element::kTet10},
                                     {Law::kCorotational, Element::kTet4},
                                     {Law::kNeoHookean, Element::kTet4}}) {
    auto params = Foam(element, law);
    params.poisson_ratio = 0.4;
    params.options.residual = 1e-9;
    SolidModel direct(mesh, Bottom(mesh), params);
    params.limits.factor_bytes = 0;
    SolidModel iterated(mesh, Bottom(mesh), params);
    EXPECT_NE(direct.info().remark, iterated.info().remark);
    for (const Contact& contact :
         {Push({0.6, 0.6, 1}, {0, 0, -300}, 0.7), Move({0.4, 0.4, 1}, {0.3, 0.1, -0.35}, 0.5),
          Move({0.5, 0.5, 1}, {0.2, 0, 0.5})}) {
      const auto a = Answer(direct, contact), b = Answer(iterated, contact);
      ASSERT_NE(a.validity, Validity::kFailed) << direct.failure();
      ASSERT_EQ(b.validity, a.validity) << iterated.failure();
      EXPECT_LT((a.force_O - b.force_O).norm(), 1e-6 * a.force_O.norm());
      EXPECT_LT((a.displacement_O - b.displacement_O).norm(), 1e-6 * a.displacement_O.norm());
    }
  }
}

// A thread that is one cell wide, whose bending the coarse grid cannot represent: the iterations do
// not converge and a factor is used, with the same answer as a model that uses it from the start.
TEST(SolidModel, SlowIterationsAreReplacedByAFactor) {
  const SolidMesh mesh = MeshBox({1, 0.004, 0.004}, {250, 1, 1});
  const HeldNodes held = FixedWhere(mesh, [](const Vector3d& p) { return p.x() == 0; });
  auto params = Foam(Element::kTet4, Law::kNeoHookean);
  params.options.residual = 1e-8;
  SolidModel direct(mesh, held, params);
  params.limits.iterated_flops = 0;
  SolidModel iterated(mesh, held, params);
  EXPECT_NE(direct.info().remark, iterated.info().remark);
  const Contact contact = Push({1, 0.004, 0.004}, {0, 0, 1e-9});
  const auto a = Answer(direct, contact), b = Answer(iterated, contact);
  ASSERT_NE(b.validity, Validity::kFailed) << iterated.failure();
  EXPECT_LT((a.displacement_O - b.displacement_O).norm(), 1e-5 * a.displacement_O.norm());
}

// An incompressible body whose whole surface is moved inwards has no solution, and the model
// reports it.
TEST(SolidModel, IncompressibleBodiesKeepTheirVolume) {
  const SolidMesh mesh = MeshBox({1, 1, 1}, {2, 2, 2});
  auto params = Foam(Element::kTet10, Law::kLinear);
  params.poisson_ratio = 0.5;
  SolidModel model(mesh, Nothing(mesh), params);
  std::vector<Contact> contacts;
  for (const auto& p : model.mesh().touch_surface.nodes) {
    const Vector3d centre = Vector3d::Constant(0.5);
    if ((p - centre).lpNorm<Eigen::Infinity>() < 0.499) continue;
    contacts.push_back(Move(p, -0.01 * (p - centre)));
  }
  std::vector<ContactResponse> responses(contacts.size());
  model.Respond(contacts, responses);
  EXPECT_EQ(responses[0].validity, Validity::kFailed);
  EXPECT_NE(model.failure().find("volume"), std::string::npos) << model.failure();
}

// A cube pressed through its own bottom gives a flagged answer or a failure with a reason, and
// later returns to rest.
TEST(SolidModel, FullInversionIsFlaggedAndForgotten) {
  const SolidMesh mesh = MeshBox({1, 1, 1}, {2, 2, 2});
  for (const Law law : {Law::kLinear, Law::kCorotational, Law::kNeoHookean}) {
    SolidModel model(mesh, Bottom(mesh), Foam(Element::kTet10, law));
    for (const double depth : {0.5, 1.5, 5.0}) {
      const auto response = Answer(model, Move({0.5, 0.5, 1}, {0, 0, -depth}));
      EXPECT_NE(response.validity, Validity::kValid);
      EXPECT_TRUE(response.force_O.allFinite());
      EXPECT_EQ(response.validity == Validity::kFailed, !model.failure().empty());
    }
    model.Respond({}, {});
    EXPECT_TRUE(model.failure().empty()) << model.failure();
    EXPECT_LT(model.displacement(NodeAt(model, 1, {0.5, 0.5, 1})).norm(), 1e-5);
  }
}

}  // namespace
}  // namespace palpate
