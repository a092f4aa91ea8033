#include "slave/mechanics/bem/bem2d_model.h"

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/mechanics/mesh_resolution.h"
#include "tests/slave/mechanics/bodies.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

constexpr Bem2dModel::Params kSiliconeBody{.young_modulus = 127e3, .thickness = 9e-3};
constexpr int kTop = 37;  // element at the centre of the top side of a block of 60 elements

ReferenceProblem Silicone(int elements = 60) {
  return bodies::Block(elements, 0.088, 0.49, Plane::kStress);
}

// Reference: the same block with elements twelve times shorter. A tool that is shorter than an
// element is flagged; a valid answer is within 3 %.
TEST(Bem2dModel, AToolThatElementsAreTooLongForIsExtrapolated) {
  Bem2dModel fine(Silicone(720), kSiliconeBody), coarse(Silicone(60), kSiliconeBody);
  int valid = 0, flagged = 0;
  for (const double width : {1.5e-3, 2.5e-3, 4e-3, 5.9e-3, 12e-3, 17.6e-3}) {
    Contact press = bodies::Move(-1, {0, -1e-3});
    press.p_O = {0.044, 0.088, 0};
    press.width = width;
    const ContactResponse is = bodies::Respond(coarse, {press})[0];
    const ContactResponse should = bodies::Respond(fine, {press})[0];
    EXPECT_EQ(should.validity, Validity::kValid) << width;
    const double off = std::abs(is.force_O.y() / should.force_O.y() - 1);
    const bool is_valid = is.validity == Validity::kValid;
    EXPECT_LT(is_valid ? off : 0, 0.03) << width;
    if (!is_valid) EXPECT_EQ(is.flag_reason, kCoarsePatch) << width;
    (is_valid ? valid : flagged) += 1;
  }
  EXPECT_GT(valid, 1);
  EXPECT_GT(flagged, 1);
}

// Reference: without friction, traction and force of a contact are parallel. The sum of the
// vertices' tractions, times their shares of the boundary, is the force. There is no traction
// elsewhere, not even on the supports.
TEST(Bem2dModel, TractionOnTheVerticesAddsUpToTheForceOfTheTool) {
  Bem2dModel::Params params = kSiliconeBody;
  params.contact = ContactLaw::kFrictionless;
  for (const ElementOrder order : {ElementOrder::kConstant, ElementOrder::kQuadratic}) {
    ReferenceProblem problem = Silicone();
    problem.order = order;
    Bem2dModel model(std::move(problem), params);
    Contact press = bodies::Move(kTop, {0, -1e-3});
    press.width = 20e-3;
    Solution solution;
    const auto response = bodies::Respond(model, {press}, &solution).front();
    bodies::Respond(model, {bodies::Move(20, {-1e-3, 0})});  // other queries do not count
    std::vector<float> pascals;
    model.Tractions(solution, &pascals);
    const BoundaryMesh& mesh = model.greens_functions().problem().mesh;
    double force = 0;
    int pushed = 0;
    for (int i = 0; i < mesh.size(); ++i) {
      const auto k = static_cast<std::size_t>(i),
                 before = static_cast<std::size_t>(mesh.Previous(i));
      const double length = (mesh.elements[k].length() + mesh.elements[before].length()) / 2;
      force += static_cast<double>(pascals[k]) * length * params.thickness;
      pushed += pascals[k] > 0 ? 1 : 0;
      if (mesh.elements[k].a.y() < 1e-9) {
        EXPECT_EQ(pascals[k], 0) << "of the support";
      }
    }
    EXPECT_NEAR(force / response.force_O.norm(), 1, 1e-6);
    EXPECT_LE(pushed, 6) << "four elements of 5.9 mm at most";
  }
}

// Law: along the surface the tool slides, on fixed elements too.
TEST(Bem2dModel, AFrictionlessContactSlidesAlongTheSurface) {
  Bem2dModel::Params params = kSiliconeBody;
  params.contact = ContactLaw::kFrictionless;
  Bem2dModel model(Silicone(), params);
  EXPECT_EQ(bodies::Respond(model, {bodies::Move(kTop, {1e-3, 0})}).front().force_O.norm(), 0);
  const auto rest = bodies::Respond(model, {bodies::Move(15, {0, 0}), bodies::Load(25, {-0.1, 0})});
  EXPECT_NE(rest[0].force_O.x(), 0);  // held along its normal
  EXPECT_EQ(rest[0].force_O.y(), 0);
  EXPECT_EQ(bodies::Respond(model, {bodies::Move(0, {1e-3, 0})}).front().force_O.norm(), 0);
  EXPECT_EQ(bodies::Respond(model, {bodies::Move(0, {0, 1e-3})}).front().validity,
            Validity::kFailed);
}

// Reference: a fresh model, which has no set to mistake the new one for.
TEST(Bem2dModel, AChangedContactSetIsNoticed) {
  Bem2dModel::Params params = kSiliconeBody;
  params.contact = ContactLaw::kFrictionless;
  Bem2dModel kept(Silicone(), params);
  Contact contact = bodies::Move(kTop, {0, -1e-3});
  contact.p_O = {0.044, 0.088, 0};
  contact.width = 0.02;
  const auto expect_fresh = [&](const char* change) {
    Bem2dModel fresh(Silicone(), params);
    const auto response = bodies::Respond(kept, {contact}).front();
    EXPECT_EQ(response.validity, Validity::kValid) << change;
    EXPECT_EQ(response.force_O, bodies::Respond(fresh, {contact}).front().force_O) << change;
  };
  expect_fresh("the first set");
  contact.width = 0.03;
  expect_fresh("width");
  contact.p_O.x() = 0.047;
  expect_fresh("place");
  contact.element = kTop - 1;
  expect_fresh("element");
  contact.prescribed_O = {0.5e-3, -1e-3, 0};
  expect_fresh("displacement");
  contact.kind = Contact::Kind::kForce;
  contact.prescribed_O = {0, -0.1, 0};
  expect_fresh("kind");
}

// A contact out of the plane, a load on a fixed element, and frictionless contacts alone on a body
// without supports, which can slide: the model returns a failure instead of an arbitrary answer.
TEST(Bem2dModel, WhatHasNoAnswerFails) {
  const auto expect_failure = [](Bem2dModel& model, const std::vector<Contact>& contacts) {
    EXPECT_EQ(bodies::Respond(model, contacts).front().validity, Validity::kFailed);
    EXPECT_FALSE(model.failure().empty());
  };
  Bem2dModel model(Silicone(), kSiliconeBody);
  Contact aside = bodies::Move(kTop, {0, -1e-3});
  aside.prescribed_O.z() = 1e-3;
  expect_failure(model, {aside});
  expect_failure(model, {bodies::Load(3, {0, -1e-3})});
  Bem2dModel::Params params = kSiliconeBody;
  params.contact = ContactLaw::kFrictionless;
  Bem2dModel sliding(bodies::Free(MeshRectangle(0.088, 0.088, 60), 0.49, Plane::kStress), params);
  expect_failure(sliding, {bodies::Move(7, {0, 1e-3}), bodies::Move(37, {0, -1e-3})});
}

// Reference: equilibrium, the reactions of the held side carry the load (1.3 % at 60 elements).
TEST(Bem2dModel, AZeroDisplacementOnHeldElementsReportsTheReaction) {
  Bem2dModel model(Silicone(), kSiliconeBody);
  std::vector<Contact> contacts{bodies::Load(kTop, {0, -0.5})};
  for (int i = 0; i < 15; ++i) contacts.push_back(bodies::Move(i, {0, 0}));
  const auto responses = bodies::Respond(model, contacts);
  double sum = 0;
  for (std::size_t i = 1; i < responses.size(); ++i) sum += responses[i].force_O.y();
  EXPECT_NEAR(sum, 0.5, 0.5 * 0.02);
}

TEST(Bem2dModel, ABodyThatNothingHoldsTakesBalancedLoadsOnly) {
  Bem2dModel model(bodies::Free(MeshRectangle(0.088, 0.088, 60), 0.49, Plane::kStress),
                   kSiliconeBody);
  Solution solution;
  const auto squeeze =
      bodies::Respond(model, {bodies::Load(7, {0, 0.5}), bodies::Load(37, {0, -0.5})}, &solution);
  ASSERT_EQ(squeeze[0].validity, Validity::kValid);
  EXPECT_NEAR(squeeze[0].displacement_O.y(), -squeeze[1].displacement_O.y(), 1e-12);
  const std::vector<Vector2d> displacement = model.Boundary(solution).displacement;
  Vector2d mean = Vector2d::Zero();
  double turn = 0;
  const auto& elements = model.greens_functions().problem().mesh.elements;
  for (std::size_t i = 0; i < 60; ++i) {
    const Vector2d p = elements[i].midpoint() - Vector2d(0.044, 0.044);
    mean += displacement[i] / 60;
    turn += p.x() * displacement[i].y() - p.y() * displacement[i].x();
  }
  EXPECT_LT(mean.norm(), 1e-12);
  EXPECT_LT(std::abs(turn), 1e-12);

  const auto fails = [&](const std::vector<Contact>& contacts) {
    return bodies::Respond(model, contacts).front().validity == Validity::kFailed;
  };
  EXPECT_TRUE(fails({bodies::Load(7, {0, 0.5})})) << "a force alone";
  EXPECT_TRUE(fails({bodies::Load(6, {0, 0.5}), bodies::Load(37, {0, -0.5})})) << "a couple";
  EXPECT_TRUE(fails({bodies::Load(7, {0, 0.5}), bodies::Load(37, {0, -0.4999})}));
}

TEST(Bem2dModel, AllAroundPrescribedIsRefusedWhereIncompressible) {
  Bem2dModel model(bodies::Free(MeshDisc(1, 24), 0.5, Plane::kStrain), kSiliconeBody);
  std::vector<Contact> contacts;
  for (int i = 0; i < 24; ++i) contacts.push_back(bodies::Move(i, {1e-3, 0}));
  EXPECT_EQ(bodies::Respond(model, contacts)[0].validity, Validity::kFailed);
  contacts.pop_back();
  const auto responses = bodies::Respond(model, contacts);
  EXPECT_EQ(responses[0].validity, Validity::kValid);
  EXPECT_LT(responses[0].force_O.norm(),
            1e-9 * kSiliconeBody.young_modulus * kSiliconeBody.thickness);
}

// One contact moves, one begins, one ends. Reference: a fresh model.
TEST(Bem2dModel, ContactsComeMoveAndGoWithoutAllocating) {
  for (const ElementOrder order : {ElementOrder::kConstant, ElementOrder::kLinear}) {
    ReferenceProblem problem = Silicone(160);
    problem.order = order;
    Bem2dModel model(problem, kSiliconeBody);
    std::vector<Contact> contacts;
    for (int i = 0; i < 20; ++i) contacts.push_back(bodies::Move(42 + 5 * i, {1e-4 * i, -1e-3}));
    std::vector<ContactResponse> responses(contacts.size());
    const auto tick = [&](int t) {
      const int turn = t % 20;
      contacts[static_cast<std::size_t>(turn)].element = 42 + 5 * turn + t / 20 % 4;
      const std::size_t count = t % 3 == 0 ? 19 : 20;
      model.Respond(std::span(contacts).first(count), std::span(responses).first(count));
      return responses[0].validity == Validity::kValid;
    };
    for (int t = 0; t < 80; ++t) ASSERT_TRUE(tick(t));
    const long before = AllocationCount();
    bool valid = true;
    for (int t = 80; t < 2000; ++t) valid = tick(t) && valid;
    EXPECT_EQ(AllocationCount(), before);
    EXPECT_TRUE(valid);
    Bem2dModel fresh(problem, kSiliconeBody);
    tick(2000);
    const auto expected = bodies::Respond(fresh, contacts);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_LT((responses[i].force_O - expected[i].force_O).norm(),
                1e-10 * expected[i].force_O.norm());
      EXPECT_LT((responses[i].stiffness_O - expected[i].stiffness_O).norm(),
                1e-10 * expected[i].stiffness_O.norm());
    }
  }
}

}  // namespace
}  // namespace palpate
