// The foam cube and the cantilever of the references: discrete answers, to the last digits given.

#include <gtest/gtest.h>

#include "tests/slave/mechanics/fem/solids.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using solids::Displacement;
using solids::Respond;

struct Cube {
  explicit Cube(const nlohmann::json& c)
      : side(c.at("params").at("L")),
        cells(c.at("params").at("mesh").at("n")),
        mesh(MeshBox({side, side, side}, {cells, cells, cells})),
        held(solids::HeldWhere(mesh, [](const Vector3d& p) { return p.z() < 1e-9; })),
        reported(solids::NodeAt(mesh, solids::VectorOf(c.at("params").at("reported_node")))),
        corner(solids::NodeAt(mesh, {side, side, side})) {}

  // The pressure patch, as loads on nodes: triangles of the top whose centroid lies inside.
  [[nodiscard]] std::vector<Contact> Pressure(const nlohmann::json& params, double share) const {
    const double low = params.at("patch").at(0), high = params.at("patch").at(1);
    const SurfaceMesh surface = SurfaceOf(mesh);
    std::vector<std::array<int, 3>> loaded;
    for (const auto& t : surface.triangles) {
      Vector3d centre = Vector3d::Zero();
      for (const int i : t) centre += surface.nodes[static_cast<std::size_t>(i)] / 3;
      const bool inside = centre.x() > low && centre.x() < high && centre.y() > low &&
                          centre.y() < high && centre.z() > side - 1e-9;
      if (inside) loaded.push_back(t);
    }
    const double force = share * params.at("total_force_N").get<double>();
    std::vector<Contact> contacts;
    for (const auto& t : loaded) {
      for (const int i : t) {
        contacts.push_back(
            solids::Push(mesh, i, {0, 0, -force / (3.0 * static_cast<double>(loaded.size()))}));
      }
    }
    return contacts;
  }

  double side;
  int cells;
  SolidMesh mesh;
  solids::Held held;
  int reported, corner;
};

void ExpectCase(DeformationModel& model, const Solution& solution, const Cube& cube,
                const nlohmann::json& expected, double tolerance) {
  const auto u = Displacement(model, solution);
  const Vector3d top = solids::VectorOf(expected.at("u_nearest_top_centre"));
  const Vector3d corner = solids::VectorOf(expected.at("u_corner_LLL"));
  EXPECT_LT((u[static_cast<std::size_t>(cube.reported)] - top).norm() / top.norm(), tolerance);
  EXPECT_LT((u[static_cast<std::size_t>(cube.corner)] - corner).norm() / corner.norm(), tolerance);
}

class CubeTest : public testing::TestWithParam<const char*> {};

// Reference d, cube_n*: the one solution of the discrete equations, by an assembly of its own.
// Tolerances as given there.
TEST_P(CubeTest, LinearAndCorotationalAnswersAreTheDiscreteOnes) {
  PALPATE_CASE_OR_SKIP(given, GetParam());
  const Cube cube(given);
  const auto& expected = given.at("expected");
  FemModel linear(cube.mesh, cube.held, solids::Linear(solids::Foam()));
  Solution solution;
  Respond(linear, cube.Pressure(given.at("params"), 1), &solution);
  ExpectCase(linear, solution, cube, expected.at("linear_patch"), 1e-8);

  auto heavy = solids::Linear(solids::Foam());
  heavy.options.gravity_O = {0, 0, -9.80665};
  FemModel weighing(cube.mesh, cube.held, heavy);
  Respond(weighing, {}, &solution);
  ExpectCase(weighing, solution, cube, expected.at("linear_gravity"), 1e-8);

  for (const auto& [key, share] : {std::pair{"corotational_patch_quarter_force", 0.25},
                                   {"corotational_patch_full_force", 1.0}}) {
    if (!expected.contains(key)) continue;
    for (const auto tangent : {FemOptions::Tangent::kWarped, FemOptions::Tangent::kExact}) {
      auto params = solids::Foam();
      params.options.tangent = tangent;
      FemModel model(cube.mesh, cube.held, params);
      const auto responses = Respond(model, cube.Pressure(given.at("params"), share), &solution);
      EXPECT_EQ(responses.front().validity, Validity::kValid) << model.failure();
      ExpectCase(model, solution, cube, expected.at(key), 1e-6);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AllMeshes, CubeTest, testing::Values("cube_n3", "cube_n6", "cube_n12"));

// Mean deflection of the end face of a cantilever of n x n cells under a shear load that is uniform
// over it: the mean that the load's work is done along.
double MeanTipDeflection(const nlohmann::json& p, int n, double nu, Validity* validity) {
  const double L = p.at("L"), h = p.at("h"), w = p.at("w"), P = p.at("P");
  const SolidMesh mesh = MeshBox({L, w, h}, {10 * n, n, n});
  const auto held = solids::HeldWhere(mesh, [](const Vector3d& x) { return x.x() < 1e-9; });
  auto params = solids::Linear(solids::Foam());
  params.material = {.young_modulus = p.at("E"), .poisson_ratio = nu};
  FemModel model(mesh, held, params);
  std::vector<Contact> contacts;
  for (const auto& t : SurfaceOf(mesh).triangles) {
    bool end = true;
    for (const int i : t) end = end && mesh.nodes[static_cast<std::size_t>(i)].x() > L - 1e-9;
    for (const int i : t) {
      if (end) contacts.push_back(solids::Push(mesh, i, {0, 0, -P / (6.0 * n * n)}));
    }
  }
  const auto responses = Respond(model, contacts);
  double work = 0;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    work += contacts[k].prescribed_O.dot(responses[k].displacement_O);
  }
  *validity = responses.front().validity;
  return work / P;
}

// Reference d, cantilever_timoshenko: discrete rows.
TEST(FemCantilever, TheTipDeflectsAsTheDiscreteBeam) {
  PALPATE_CASE_OR_SKIP(given, "cantilever_timoshenko");
  for (const auto& row : given.at("expected").at("linear_tet_discrete")) {
    const int n = row.at("cells_through_height");
    for (const auto& [key, nu] :
         {std::pair{"nu_0.15", 0.15}, {"nu_0.45", 0.45}, {"nu_0.499", 0.499}}) {
      Validity validity{};
      const double deflection = MeanTipDeflection(given.at("params"), n, nu, &validity);
      const double expected = row.at("mean_tip_deflection").at(key);
      EXPECT_NEAR(deflection / expected, 1, 1e-8) << n << " " << key;
      EXPECT_EQ(validity, Validity::kExtrapolated);  // at best 22 % too stiff against the theory
    }
  }
}

// Reference d, cantilever_timoshenko: beam theory. Linear tetrahedra come to it from the stiff side
// with an order that rises to the two of their displacements.
TEST(FemCantilever, ApproachesBeamTheoryWithRisingOrder) {
  PALPATE_CASE_OR_SKIP(given, "cantilever_timoshenko");
  const double theory = given.at("expected").at("beam_theory");
  double previous = 0, last_order = 0;
  for (const int n : {1, 2, 4, 8}) {
    Validity validity{};
    const double error =
        1 -
        MeanTipDeflection(given.at("params"), n, given.at("params").at("nu"), &validity) / theory;
    const double order = previous > 0 ? std::log2(previous / error) : 0;
    EXPECT_GT(error, 0);
    EXPECT_EQ(validity, error > 0.1 ? Validity::kExtrapolated : Validity::kValid);
    EXPECT_GE(order, last_order);
    previous = error;
    last_order = order;
  }
  EXPECT_NEAR(last_order, 2, 0.35);
}

}  // namespace
}  // namespace palpate
