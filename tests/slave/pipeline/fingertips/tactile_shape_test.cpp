#include <cstddef>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/factory/make_model.h"
#include "slave/pipeline/fingertips/tactile_estimator.h"
#include "tests/slave/pipeline/fingertips/tactile_scene.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using namespace testing_fakes;

// Without an answer of the model the last shape is kept with its time, and estimates continue. At
// rest the shape is the model's again.
TEST(TactileEstimatorTest, BeyondTheModelTheLastKnownShapeIsReported) {
  Touching t(CubeScene(kAbove));
  t.Press({0, 0, -0.2}, {0, 0, -0.003});
  const BoundaryShape known = t.estimator.Shape({.nodal_forces = true});
  ASSERT_NE(known.validity, Validity::kFailed);
  ASSERT_NE(known.positions, known.rest);
  const ContactEstimate& estimate = t.Press({0, 0, -7}, {0, 0, -0.003});
  const BoundaryShape beyond = t.estimator.Shape({.nodal_forces = true});
  ASSERT_EQ(beyond.validity, Validity::kFailed);
  EXPECT_EQ(beyond.positions, known.positions);
  EXPECT_EQ(beyond.sensed_at, known.sensed_at);
  EXPECT_LT(beyond.sensed_at, estimate.sensed_at);
  EXPECT_EQ(beyond.nodal_forces.size(), beyond.rest.size());
  EXPECT_NE(beyond.nodal_forces, known.nodal_forces);
  t.hand.active[0] = false;
  t.hand.forces_F[0].setZero();
  t.Estimate(20);
  const BoundaryShape after = t.estimator.Shape({});
  EXPECT_NE(after.validity, Validity::kFailed);
  EXPECT_GT(after.sensed_at, beyond.sensed_at);
}

// Sum over the nodes of the streamed forces, frame S, and on how many nodes they act.
struct Streamed {
  Vector3d sum{0, 0, 0};
  int nodes = 0;
};
Streamed Forces(Touching& t) {
  const BoundaryShape shape = t.estimator.Shape({.nodal_forces = true});
  Streamed streamed;
  for (std::size_t i = 0; i + 2 < shape.nodal_forces.size(); i += 3) {
    const Eigen::Vector3f f(&shape.nodal_forces[i]);
    streamed.sum += f.cast<double>();
    if (f.norm() > 0) ++streamed.nodes;
  }
  return streamed;
}

// The tolerance is single precision of 0.2 N. The force of a pulled contact, which the model
// ignores, is also estimated.
TEST(TactileEstimatorTest, StreamedForcesAreThoseEstimatedForEveryKindOfContact) {
  const Isometry3d turned(Eigen::AngleAxisd(0.5, Vector3d::UnitZ()));
  for (const char* extra :
       {"", ", hold: displacement", ", patch: 22 mm", ", hold: displacement, patch: 22 mm"}) {
    Scene scene = CubeScene(kAbove + extra);
    scene.object.X_SO = turned;
    scene.sense.Find<Tactile>()->fingers[0].X_SF.translation() =
        turned * Vector3d(0.02, 0.02, 0.047);
    scene.manipulator.home = turned * Vector3d(0.02, 0.02, 0.04);
    Touching t(scene);
    for (const Vector3d& force : {Vector3d(0.03, 0.01, -0.2), Vector3d(0.03, 0.01, 0.05)}) {
      const ContactEstimate& estimate = t.Press(force, {0, 0, -0.004});
      ASSERT_TRUE(estimate.force && t.estimator.finger(0).p_S_contact);
      EXPECT_NEAR((Forces(t).sum + *estimate.force).norm(), 0, 1e-7) << extra;
    }
  }
}

// Reference: the model alone, each streamed force put on its node by itself; loads superpose, so
// the object deforms as under the patch. Single precision of forces and places: 1e-7 m of 1 mm.
TEST(TactileEstimatorTest, StreamedForcesOfAPatchAreSpreadAsTheModelSpreadsThem) {
  Touching t(CubeScene(kAbove + ", patch: 22 mm"));
  t.Press({0.01, 0, -0.1}, {0, 0, -0.002});
  EXPECT_GE(Forces(t).nodes, 9);  // the corners of the four central faces
  const BoundaryShape shape = t.estimator.Shape({.nodal_forces = true});
  const auto at = [](const std::vector<float>& values, std::size_t i) -> Vector3d {
    return Eigen::Vector3f(&values[i]).cast<double>();
  };
  std::vector<Contact> loads;
  for (std::size_t i = 0; i < shape.nodal_forces.size(); i += 3) {
    const Vector3d force = at(shape.nodal_forces, i);
    if (force.norm() == 0) continue;
    loads.push_back(
        {.kind = Contact::Kind::kForce, .p_O = at(shape.rest, i), .prescribed_O = force});
  }
  const auto model = MakeModel(t.scene, MeshObject(t.scene, std::nullopt));
  Solution solution;
  model->Solve(loads, &solution);
  std::vector<Vector3d> u;
  model->Displacements(solution, &u);
  const std::vector<Vector3d> p = t.Nodes();
  for (std::size_t i = 0; i < u.size(); ++i) {
    EXPECT_NEAR((p[i] - t.estimator.body()->surface.nodes[i] - u[i]).norm(), 0, 1e-6) << i;
  }
}

TEST(TactileEstimatorTest, NoForcesAreStreamedWhileOneIsUnknown) {
  const Scene scene = CubeScene(kAbove + ", hold: displacement");
  TactileSenses senses = Fakes();
  senses.network = nullptr;
  TactileEstimator estimator(scene, senses);
  Hand hand(1);
  for (int i = 0; i < kRest + 2 * kWindow; ++i) {
    hand.active[0] = i > kRest;
    estimator.Estimate(hand.Next(), scene.manipulator.home - Vector3d(0, 0, 0.004));
  }
  ASSERT_TRUE(estimator.finger(0).p_S_contact && !estimator.finger(0).force);
  const BoundaryShape shape = estimator.Shape({.nodal_forces = true});
  EXPECT_FALSE(shape.positions.empty());
  EXPECT_TRUE(shape.nodal_forces.empty());
}

}  // namespace
}  // namespace palpate
