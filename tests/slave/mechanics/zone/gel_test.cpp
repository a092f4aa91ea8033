// A gel of 25.25 x 20.75 x 4 mm on a rigid base, E 100 kPa, nu 0.49, under rigid spheres: against
// published forces (ANSYS, not converged by their own words) and against the linear theory of the
// layer with the same friction (layer_contact.py).
#include <algorithm>
#include <memory>

#include <gtest/gtest.h>

#include "slave/mechanics/fem/zone/fem_zone_model.h"
#include "tests/slave/mechanics/zone/graded_slab.h"

namespace palpate {
namespace {

using namespace zone_tests;  // NOLINT(google-build-using-namespace): its helpers are for here
using Eigen::Vector3d;

class FineGel : public testing::Test {
 protected:
  // Steps of `side` up to `across` from the middle and down to `deep`, then coarser [m].
  void Make(double radius, double friction, double side, double across, double deep) {
    const auto half = [&](double width) {
      return Mirrored(GradedSteps(across, side, 1.5, 0.5 * width));
    };
    std::vector<double> down = Mirrored(GradedSteps(deep, side, 1.5, 0.004));
    down.resize(down.size() / 2 + 1);
    mesh_ = CrossedBox({half(0.02525), half(0.02075), down});
    FemZoneModel::Options options;
    options.contact = friction > 0 ? ContactLaw::kFriction : ContactLaw::kFrictionless;
    options.friction = friction;
    options.tool = {.shape = Tool::Shape::kRound, .radius = radius};
    options.memory_limit = std::size_t{1} << 33;
    model_ = std::make_unique<FemZoneModel>(
        mesh_, FixedWhere(mesh_, [&](const Vector3d& p) { return p.z() < -0.004 + 1e-9; }), 1e5,
        0.49, options);
  }
  Vector3d Move(double x, double depth) {
    contact_.prescribed_O = {x, 0, -depth};
    std::vector<ContactResponse> response(1);
    model_->Respond({&contact_, 1}, response);
    EXPECT_NE(response[0].validity, Validity::kFailed) << model_->failure();
    return response[0].force_O;
  }

  SolidMesh mesh_;
  std::unique_ptr<FemZoneModel> model_;
  Contact contact_{};
};

// Frictionless the force is the published one: 0.361 N. Tolerance 5 %.
TEST_F(FineGel, ASphereOf3MmPressedBy08Mm) {
  constexpr double kDepth = 0.8e-3;
  Make(0.003, 0, 0.75e-3, 1.5e-3, 1.5e-3);
  Vector3d force;
  for (int k = 1; k <= 20; ++k) force = Move(0, k * kDepth / 20);
  EXPECT_NEAR(-force.z(), 0.361, 0.05 * 0.361);
}

// With friction: the layer's theory has 0.542 N, and 0.251 N at most when the sphere is then
// dragged sideways (published: 0.502 N, which is the frictionless force, and 0.237 N). Tolerance 5
// %, 3.5 of which are cells of a fifth of the contact's radius.
TEST_F(FineGel, ASphereOf50MmPressedBy02MmAndDragged) {
  constexpr double kDepth = 0.2266e-3;
  Make(0.05, 0.5, 1e-3, 4e-3, 2e-3);
  Vector3d force;
  for (int k = 1; k <= 4; ++k) force = Move(0, k * kDepth / 4);
  EXPECT_NEAR(-force.z(), 0.542, 0.05 * 0.542);
  double most = 0;
  for (int k = 1; k <= 5; ++k) most = std::max(most, Move(k * 1e-4, kDepth).x());
  EXPECT_NEAR(most, 0.251, 0.05 * 0.251);
}

}  // namespace
}  // namespace palpate
