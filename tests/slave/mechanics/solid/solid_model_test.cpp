// SolidModel against discrete answers that have one solution, and its promises as a model.
#include "slave/mechanics/fem/solid/solid_model.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/slave/mechanics/solid/bodies.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using namespace solid_tests;  // NOLINT(google-build-using-namespace): its helpers are for here
using Eigen::Vector3d;

class DiscreteCube : public testing::TestWithParam<int> {};

// Reference: d_solid3d, cube_n3, n6, n12: the answer of four-node tetrahedra on this very mesh, by
// an assembly that is not ours. Its tolerances: linear 1e-8, co-rotational 1e-6 relative.
TEST_P(DiscreteCube, AgreesWithTheReferenceOnTheSameMesh) {
  const int n = GetParam();
  const auto reference = Reference("d_solid3d.json", "cube_n" + std::to_string(n));
  if (!reference) GTEST_SKIP() << "../shared/reference is absent";
  const SolidMesh mesh = MeshBox(Vector3d::Constant(kCube), {n, n, n});
  const Vector3d top = VectorOf(reference->at("params").at("reported_node"));
  const auto compare = [&](const SolidModel& model, const json& expected, double tolerance) {
    const Vector3d u_top = VectorOf(expected.at("u_nearest_top_centre"));
    const Vector3d u_corner = VectorOf(expected.at("u_corner_LLL"));
    EXPECT_LT((model.displacement(NodeAt(model, kCube, top)) - u_top).norm(),
              tolerance * u_top.norm());
    EXPECT_LT(
        (model.displacement(NodeAt(model, kCube, Vector3d::Constant(kCube))) - u_corner).norm(),
        tolerance * u_corner.norm());
  };
  auto params = Foam(Element::kTet4, Law::kLinear);
  {
    SolidModel model(mesh, Bottom(mesh), params);
    const auto load = SquareLoad(mesh, 1);
    std::vector<ContactResponse> responses(load.size());
    model.Respond(load, responses);
    const json& expected = reference->at("expected").at("linear_patch");
    compare(model, expected, 1e-8);
    EXPECT_NEAR(MeanDepth(load, responses) / expected.at("mean_patch_depth").get<double>(), 1,
                1e-8);
  }
  {
    params.options.gravity_O = {0, 0, -9.80665};
    SolidModel model(mesh, Bottom(mesh), params);
    model.Respond({}, {});
    compare(model, reference->at("expected").at("linear_gravity"), 1e-8);
  }
  params = Foam(Element::kTet4, Law::kCorotational);
  params.options.residual = 1e-9;
  SolidModel model(mesh, Bottom(mesh), params);
  for (const auto& [force, name] : {std::pair{0.25, "corotational_patch_quarter_force"},
                                    std::pair{1.0, "corotational_patch_full_force"}}) {
    const json& expected = reference->at("expected").at(name);
    if (!expected.at("converged").get<bool>()) continue;
    const auto load = SquareLoad(mesh, force);
    std::vector<ContactResponse> responses(load.size());
    model.Respond(load, responses);
    ASSERT_FALSE(responses.empty());
    EXPECT_EQ(responses[0].validity, Validity::kValid) << model.failure();
    compare(model, expected, 1e-6);
    EXPECT_NEAR(MeanDepth(load, responses) / expected.at("mean_patch_depth").get<double>(), 1,
                1e-6);
    EXPECT_NEAR(model.smallest_jacobian(), expected.at("min_det_F").get<double>(), 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Cells, DiscreteCube, testing::Values(3, 6));

}  // namespace
}  // namespace palpate
