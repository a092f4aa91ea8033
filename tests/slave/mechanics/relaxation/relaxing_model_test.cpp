// Compares a relaxing body with closed forms and with a body in which every element relaxes.
#include "slave/mechanics/relaxation/relaxing_model.h"

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/object_mesh.h"
#include "tests/slave/mechanics/contacts.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using contacts::Respond;
using Eigen::Vector3d;

const std::vector<RelaxationTerm> kTissueTerms{{0.3, 0.5}, {0.2, 5}};
constexpr double kRelaxationStep = 0.05;  // [s]

Scene TissueScene() {
  Scene scene;
  scene.object.geometry = BoxGeometry{{0.04, 0.04, 0.02}, {6, 6, 3}};
  scene.object.material = {
      .young_modulus = 20e3, .poisson_ratio = 0.45, .density = 0, .relaxation = kTissueTerms};
  scene.object.fixed = {{FixedPlane{2, 0}}};
  scene.object.regions = {{Ball{{0.02, 0.02, 0.01}, 0.006}, 100e3}};
  scene.model.kind = "fem-green";
  scene.model.range = 0.1;
  scene.model.fem.step = kRelaxationStep;
  return scene;
}

std::unique_ptr<DeformationModel> MakeRelaxing(const Scene& scene) {
  return MakeModel(scene, MeshObject(scene, std::nullopt));
}
std::unique_ptr<DeformationModel> MakeElastic(Scene scene) {
  scene.object.material.relaxation.clear();
  return MakeRelaxing(scene);
}

Contact PushBy(const Vector3d& p_O, const Vector3d& by,
               Contact::Kind kind = Contact::Kind::kDisplacement) {
  return {.kind = kind, .p_O = p_O, .width = 0.012, .prescribed_O = by};
}
double Relaxed(double t) {
  double g = 1;
  for (const auto& [share, time] : kTissueTerms) g += share * std::expm1(-t / time);
  return g;
}

const std::vector<Contact> kPair{PushBy({0.014, 0.02, 0.02}, {0, 1e-4, -5e-4}),
                                 PushBy({0.0333333, 0.02, 0.02}, {0, 0, -2e-4})};

// Reference: the correspondence principle; g multiplies every force of a step, moments too.
TEST(RelaxingModel, ForcesOfAStepRelaxExactlyAndStopAtTheLongTermModulus) {
  const auto model = MakeRelaxing(TissueScene()), elastic = MakeElastic(TissueScene());
  const auto at_once = Respond(*elastic, kPair);
  model->Start(kPair);
  for (int k = 1; k <= 2000; ++k) {
    const auto responses = Respond(*model, kPair);
    for (std::size_t i = 0; i < kPair.size(); ++i) {
      const Vector3d expected = Relaxed(k * kRelaxationStep) * at_once[i].force_O;
      ASSERT_LT((responses[i].force_O - expected).norm(), 1e-12 * at_once[i].force_O.norm()) << k;
      ASSERT_EQ(responses[i].moment_O.has_value(), at_once[i].moment_O.has_value());
      if (!responses[i].moment_O) continue;
      ASSERT_LT(
          (*responses[i].moment_O - Relaxed(k * kRelaxationStep) * *at_once[i].moment_O).norm(),
          1e-12 * at_once[i].moment_O->norm());
    }
  }
  const double ratio = Respond(*model, kPair)[0].force_O.norm() / at_once[0].force_O.norm();
  EXPECT_NEAR(ratio, 0.5, 1e-8);
}

// A loaded body creeps to the displacement of its long-term moduli. With a displacement at one
// place and a load at another, neither contact changes the history of the other.
TEST(RelaxingModel, LoadsCreepToTheLongTermModulus) {
  const std::vector<Contact> mixed{
      PushBy({0.014, 0.02, 0.02}, {0, 0, -0.02}, Contact::Kind::kForce),
      PushBy({0.0333333, 0.02, 0.02}, {0, 0, 0})};
  Scene scene = TissueScene();
  const auto model = MakeRelaxing(scene), elastic = MakeElastic(scene);
  scene.object = Relaxed(scene.object);
  const auto in_the_end = Respond(*MakeRelaxing(scene), mixed), at_once = Respond(*elastic, mixed);
  model->Start(mixed);
  std::vector<ContactResponse> responses;
  double last = std::abs(at_once[0].displacement_O.z()) * (1 - 1e-9);
  for (int k = 1; k <= 2000; ++k) {
    responses = Respond(*model, mixed);
    ASSERT_GE(std::abs(responses[0].displacement_O.z()), last);
    last = std::abs(responses[0].displacement_O.z());
    ASSERT_EQ(responses[0].force_O, mixed[0].prescribed_O);
  }
  // The slowest retardation time is 7 s: a fraction exp(-100 / 7) remains.
  EXPECT_NEAR(last / std::abs(in_the_end[0].displacement_O.z()), 1, 1e-6);
  EXPECT_LT((responses[1].force_O - in_the_end[1].force_O).norm(),
            1e-6 * in_the_end[1].force_O.norm());
}

// Contacts have their prescribed displacements, whatever was queried before. No time passes during
// queries.
TEST(RelaxingModel, DisplacementsOfASolutionTakeNoTime) {
  const auto model = MakeRelaxing(TissueScene()), other = MakeRelaxing(TissueScene());
  Solution first, second;
  std::vector<Vector3d> u, again;
  model->Solve(kPair, &first);
  Respond(*other, kPair);
  model->Displacements(first, &u);
  model->Solve(std::vector{kPair[1], kPair[0]}, &second);
  Respond(*other, {kPair[1], kPair[0]});
  model->Displacements(first, &again);
  EXPECT_EQ(u, again);
  const Vector3d force = Respond(*model, kPair)[0].force_O;
  EXPECT_EQ(force, Respond(*other, kPair)[0].force_O);
}

// The order of contacts does not matter, a sliding contact keeps its history, a new one has none.
TEST(RelaxingModel, MemoryFollowsTheContact) {
  const auto model = MakeRelaxing(TissueScene()), elastic = MakeElastic(TissueScene());
  const auto at_once = Respond(*elastic, kPair);
  model->Start(kPair);
  const std::vector<Contact> turned{kPair[1], kPair[0]};
  auto responses = Respond(*model, turned);
  EXPECT_LT((responses[0].force_O - Relaxed(kRelaxationStep) * at_once[1].force_O).norm(), 1e-9);
  std::vector<Contact> slid{kPair[0]};
  slid[0].p_O.x() += 0.003;
  for (int k = 0; k < 2000; ++k) responses = Respond(*model, slid);
  const Vector3d there = Respond(*elastic, slid)[0].force_O;
  EXPECT_LT((responses[0].force_O - 0.5 * there).norm(), 1e-6 * there.norm());
  std::vector<Contact> away{kPair[1]};  // moved by more than its width: a new contact
  const PronySeries series(kTissueTerms, kRelaxationStep);
  const Vector3d fresh = Respond(*elastic, away)[0].force_O;
  EXPECT_LT((Respond(*model, away)[0].force_O - series.at_once() * fresh).norm(),
            1e-9 * fresh.norm());
}

// Reference: differences of the answer to the next step. Forces and stiffness are compared without
// the factor for the mesh, which follows the direction of the force.
TEST(RelaxingModel, StiffnessIsThatOfAChangeWithinTheStep) {
  const std::vector<Contact> contact{kPair[0]};
  std::vector<Contact> further = contact;
  further[0].prescribed_O.z() -= 1e-5;
  const auto one = MakeRelaxing(TissueScene()), two = MakeRelaxing(TissueScene());
  const auto response = Respond(*one, contact)[0], deeper = Respond(*two, further)[0];
  const Vector3d change =
      deeper.force_O / deeper.mesh_factor - response.force_O / response.mesh_factor;
  const Vector3d expected = response.stiffness_O.col(2) * -1e-5 / response.mesh_factor;
  EXPECT_LT((expected - change).norm(), 1e-6 * change.norm());
}

TEST(RelaxingModel, AllocatesNothingAfterTheFirstStep) {
  const auto model = MakeRelaxing(TissueScene());
  std::vector<ContactResponse> responses(2);
  for (int k = 0; k < 3; ++k) model->Respond(kPair, responses);
  const long before = AllocationCount();
  for (int k = 0; k < 100; ++k) model->Respond(kPair, responses);
  EXPECT_EQ(AllocationCount() - before, 0);
}

// A failed contact loses its history: the next answer is that of a body at rest.
TEST(RelaxingModel, AfterAFailureItBeginsAtRest) {
  const auto model = MakeRelaxing(TissueScene()), fresh = MakeRelaxing(TissueScene());
  Respond(*model, kPair);
  std::vector<Contact> bad = kPair;
  bad[1].prescribed_O.x() = std::nan("");
  for (const auto& response : Respond(*model, bad)) {
    EXPECT_EQ(response.validity, Validity::kFailed);
  }
  EXPECT_FALSE(model->failure().empty());
  EXPECT_EQ(Respond(*model, kPair)[0].force_O, Respond(*fresh, kPair)[0].force_O);
}

}  // namespace
}  // namespace palpate
