// The cantilever of the references.
#include <gtest/gtest.h>

#include "tests/slave/mechanics/fem/solids.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

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
  const auto responses = solids::Respond(model, contacts);
  double work = 0;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    work += contacts[k].prescribed_O.dot(responses[k].displacement_O);
  }
  *validity = responses.front().validity;
  return work / P;
}

// Reference d, cantilever_timoshenko: beam theory. Linear tetrahedra come to it from the stiff side
// with an order that rises to the two of their displacements.
TEST(FemCantilever, ApproachesBeamTheoryWithRisingOrder) {
  PALPATE_CASE_OR_SKIP(given, "d_solid3d.json", "cantilever_timoshenko");
  const double theory = given.at("expected").at("beam_theory");
  double previous = 0, last_order = 0;
  for (const int n : {1, 2, 4, 8}) {
    Validity validity{};
    const double error =
        1 -
        MeanTipDeflection(given.at("params"), n, given.at("params").at("nu"), &validity) / theory;
    const double order = previous > 0 ? std::log2(previous / error) : 0;
    EXPECT_GT(error, 0);
    EXPECT_EQ(validity, error > 0.05 ? Validity::kExtrapolated : Validity::kValid) << error;
    EXPECT_GE(order, last_order);
    previous = error;
    last_order = order;
  }
  EXPECT_NEAR(last_order, 2, 0.35);
}

}  // namespace
}  // namespace palpate
