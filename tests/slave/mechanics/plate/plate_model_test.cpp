#include "slave/mechanics/plate/plate_model.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/mechanics/plate/plate_surface.h"
#include "slave/mesh/index.h"
#include "tests/slave/mechanics/contacts.h"
#include "tests/slave/mechanics/plate/presses.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using contacts::Respond;
using plates::Loaded;
using plates::Moved;
using testing::HasSubstr;

const PlateModel::Params kPlateRubber{
    .radius = 0.039, .thickness = 0.001, .young_modulus = 27.2e6, .poisson_ratio = 0.45};

TEST(PlateModel, TheShapePassesThroughWhatIsPrescribed) {
  PlateModel model(kPlateRubber);
  Solution solution;
  const auto responses =
      Respond(model, {Moved({0.01, 0}, 2e-4, 0.004), Loaded({-0.02, 0.003}, 0.05)}, &solution);
  Respond(model, {Moved({0.02, 0}, 1e-4)});  // other queries do not count
  EXPECT_NEAR(model.Displacement(solution, {0.01, 0}), -2e-4, 1e-16);
  EXPECT_NEAR(model.Displacement(solution, {-0.02, 0.003}) / responses[1].displacement_O.z(), 1,
              1e-12);
  std::vector<Eigen::Vector3d> field;
  model.Displacements(solution, &field);
  const auto grid = MembraneGrid(kPlateRubber.radius);
  ASSERT_EQ(field.size(), grid.nodes.size());
  EXPECT_NEAR(field[100].z() / model.Displacement(solution, grid.nodes[100].head<2>()), 1, 1e-12);
  EXPECT_EQ(field.back(), Eigen::Vector3d::Zero());
}

// Reference: the difference of two answers, exact for a linear plate. The two moved contacts are of
// different stiffness.
TEST(PlateModel, StiffnessBesideMovedContactsIsTheDerivative) {
  PlateModel model(kPlateRubber);
  const auto answer = [&](double force) {
    return Respond(model, {Loaded({0.01, 0}, force), Moved({-0.01, 0.004}, 1e-4),
                           Moved({0.03, -0.01}, 1e-4)})[0];
  };
  const ContactResponse less = answer(0.01), more = answer(0.02);
  const double change = (more.displacement_O - less.displacement_O).z();
  EXPECT_NEAR(less.stiffness_O(2, 2) * change / -0.01, 1, 1e-9);
}

// Reference: a regular 144-gon's area, and Euler's formula for a disc.
TEST(MembraneGrid, CoversTheDiscOnce) {
  const SurfaceMesh grid = MembraneGrid(1);
  double area = 0;
  for (const auto& [i, j, k] : grid.triangles) {
    const auto node = [&](int n) { return grid.nodes.at(Index(n)); };
    const double twice = (node(j) - node(i)).cross(node(k) - node(i)).z();
    EXPECT_GT(twice, 0);
    area += twice / 2;
  }
  EXPECT_NEAR(area, 72 * std::sin(2 * std::numbers::pi / 144), 1e-12);
  EXPECT_EQ(grid.triangles.size(), 2 * grid.nodes.size() - 2 - 144);
}

TEST(PlateModel, FailsWithItsReasonAndRecovers) {
  PlateModel model(kPlateRubber);
  Solution solution;
  const std::vector near = {Moved({0, 0}, 1e-4), Moved({1e-8, 0}, 2e-4)};
  EXPECT_EQ(Respond(model, near, &solution)[0].validity, Validity::kFailed);
  EXPECT_THAT(std::string(model.failure()), HasSubstr("too close"));
  EXPECT_EQ(model.Displacement(solution, {0, 0}), 0);
  std::vector<ContactResponse> too_few(1);
  model.Respond(near, too_few);
  EXPECT_EQ(too_few[0].validity, Validity::kFailed);
  EXPECT_EQ(Respond(model, {Moved({0, 0}, 1e-4)})[0].validity, Validity::kValid);
  EXPECT_EQ(model.failure(), "");
}

// Paper C: deflections up to half the thickness. The range is relative to the diameter.
TEST(PlateModel, ItsRangeIsHalfTheThickness) {
  EXPECT_NEAR(PlateModel(kPlateRubber).info().range, 0.5 * 0.001 / 0.078, 1e-15);
}

TEST(PlateModel, RefusesImpossibleParams) {
  const auto refusal = [](PlateModel::Params params) -> std::string {
    return Thrown<std::invalid_argument>([&] { const PlateModel refused(params); });
  };
  const double nan = std::nan("");
  EXPECT_THAT(refusal({0, 1e-3, 1e6, 0.3}), HasSubstr("radius = 0: expected"));
  EXPECT_THAT(refusal({0.039, 5e-3, 1e6, 0.3}), HasSubstr("0 < t <= 0.0039 (radius / 10)"));
  EXPECT_THAT(refusal({0.039, nan, 1e6, 0.3}), HasSubstr("thickness"));
  EXPECT_THAT(refusal({0.039, 1e-3, -1, 0.3}), HasSubstr("young_modulus"));
  EXPECT_THAT(refusal({0.039, 1e-3, 1e6, 0.51}), HasSubstr("-1 < nu <= 0.5"));
  EXPECT_THAT(refusal({0.039, 1e-3, 1e6, nan}), HasSubstr("poisson_ratio"));
  EXPECT_THAT(refusal({0.039, 1e-3, 1e6, 0.3, 0}), HasSubstr("range"));
}

}  // namespace
}  // namespace palpate
