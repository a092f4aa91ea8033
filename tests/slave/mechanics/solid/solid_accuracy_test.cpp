// How near solids come to closed forms, beams and an independent code, and how fast: printed as
// tables.
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/fem/solid/solid_model.h"
#include "tests/slave/mechanics/solid/bodies.h"

namespace palpate {
namespace {

using namespace solid_tests;  // NOLINT(google-build-using-namespace): its helpers are for here
using Eigen::Vector3d;

// Root mean square over the vertices of `displacement` minus `exact`.
double Error(const SolidModel& model, double unit,
             const std::function<Vector3d(const Vector3d&)>& exact) {
  double sum = 0;
  for (int i = 0; i < model.mesh().node_count(); ++i) {
    const Vector3d p = unit * model.mesh().nodes[static_cast<std::size_t>(i)];
    sum += (model.displacement(i) - exact(p)).squaredNorm();
  }
  return std::sqrt(sum / model.mesh().node_count());
}

// Moves every surface node of the body to where `exact` takes it.
std::vector<Contact> OnSurface(const SolidModel& model, double unit,
                               const std::function<Vector3d(const Vector3d&)>& exact) {
  std::vector<bool> outer(static_cast<std::size_t>(model.mesh().node_count()), false);
  for (const auto& t : model.mesh().touch_surface.triangles) {
    for (const int node : t) outer[static_cast<std::size_t>(node)] = true;
  }
  std::vector<Contact> contacts;
  for (std::size_t i = 0; i < outer.size(); ++i) {
    const Vector3d p = unit * model.mesh().nodes[i];
    if (outer[i]) contacts.push_back(Move(p, exact(p)));
  }
  return contacts;
}

// Reference: a field in equilibrium without body force, u = grad of the harmonic function
// e^x sin(y) z (then div u = 0 and the stress is 2 mu times its Hessian, whose divergence is the
// gradient of the Laplacian, zero). Textbook orders of the displacement: 2 with four nodes, 3 with
// ten.
TEST(ConvergenceOrder, IsTwoWithFourNodesAndThreeWithTen) {
  const double a = 1e-3;  // small, for the laws that are not linear
  const auto exact = [a](const Vector3d& p) -> Vector3d {
    return a * std::exp(p.x()) *
           Vector3d(std::sin(p.y()) * p.z(), std::cos(p.y()) * p.z(), std::sin(p.y()));
  };
  std::printf("%-6s %-9s %5s %12s %6s\n", "nodes", "pressure", "cells", "error", "order");
  for (const auto& [element, pressure, nu, order] :
       {std::tuple{Element::kTet4, Pressure::kDisplacement, 0.3, 1.8},
        std::tuple{Element::kTet4, Pressure::kAveraged, 0.49, 1.8},
        std::tuple{Element::kTet10, Pressure::kDisplacement, 0.3, 2.8},
        std::tuple{Element::kTet10, Pressure::kMixed, 0.4999, 2.8},
        std::tuple{Element::kTet10, Pressure::kMixed, 0.5, 2.8}}) {
    double before = 0, measured = 0;
    for (const int n : {2, 4, 8}) {
      if (element == Element::kTet10 && pressure == Pressure::kMixed && n == 8) continue;
      SolidModel::Params params;
      params.options.element = element;
      params.options.law = Law::kLinear;
      params.options.pressure = pressure;
      params.young_modulus = 1;
      params.poisson_ratio = nu;
      const SolidMesh mesh = MeshBox({1, 1, 1}, {n, n, n});
      SolidModel model(mesh, Nothing(mesh), params);
      const auto contacts = OnSurface(model, 1, exact);
      std::vector<ContactResponse> responses(contacts.size());
      model.Respond(contacts, responses);
      ASSERT_EQ(responses[0].validity, Validity::kValid) << model.failure();
      const double error = Error(model, 1, exact) / a;
      measured = before > 0 ? std::log2(before / error) : 0;
      std::printf("%-6d %-9s %5d %12.3e %6.2f\n", element == Element::kTet4 ? 4 : 10,
                  pressure == Pressure::kDisplacement ? "none"
                  : pressure == Pressure::kMixed      ? "mixed"
                                                      : "averaged",
                  n, error, measured);
      before = error;
    }
    EXPECT_GT(measured, order);
  }
}

// Reference: d_solid3d, cantilever_timoshenko: beam theory, 1 % for a converged body; and the
// discrete answers of four nodes at three Poisson ratios, 1e-8.
TEST(Cantilever, MeetsBeamTheoryWithTenNodesAndTheDiscreteAnswersWithFour) {
  const auto reference = Reference("d_solid3d.json", "cantilever_timoshenko");
  if (!reference) GTEST_SKIP() << "../shared/reference is absent";
  const double L = 0.2, h = 0.02, P = 2e-4;
  const auto tip_deflection = [&](Element element, Law law, int cells, double nu) {
    const SolidMesh mesh = MeshBox({L, h, h}, {10 * cells, cells, cells});
    SolidModel::Params params;
    params.options.element = element;
    params.options.law = law;
    params.options.pressure = element == Element::kTet4 ? Pressure::kDisplacement : Pressure::kAuto;
    params.young_modulus = 3000;
    params.poisson_ratio = nu;
    params.range = 1;
    SolidModel model(mesh, HeldWhere(mesh, [](const Vector3d& p) { return p.x() == 0; }), params);
    const Contact push = Push({L, h / 2, h / 2}, {0, 0, -P}, 4 * h);
    // The disc covers all triangles of the end face but also of its neighbours: by triangle.
    std::vector<Contact> contacts;
    const SurfaceMesh& surface = model.mesh().surface;
    for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
      Vector3d centroid = Vector3d::Zero();
      bool end = true;
      for (const int node : surface.triangles[static_cast<std::size_t>(t)]) {
        const Vector3d p = L * surface.nodes[static_cast<std::size_t>(node)];
        centroid += p / 3;
        end = end && p.x() > L * (1 - 1e-9);
      }
      if (!end) continue;
      contacts.push_back(Push(centroid, push.value_O / (2.0 * cells * cells), 1e-9));
      contacts.back().element = t;
    }
    EXPECT_EQ(contacts.size(), 2u * static_cast<std::size_t>(cells * cells));
    std::vector<ContactResponse> responses(contacts.size());
    model.Respond(contacts, responses);
    double deflection = 0;  // mean over the end face's nodes
    int count = 0;
    for (int i = 0; i < model.mesh().vertex_count; ++i) {
      if (model.mesh().nodes[static_cast<std::size_t>(i)].x() < 1 - 1e-9) continue;
      deflection -= model.displacement(i).z();
      ++count;
    }
    return std::pair{deflection / count, MeanDepth(contacts, responses)};
  };
  for (const auto& row : reference->at("expected").at("linear_tet_discrete")) {
    const int cells = row.at("cells_through_height").get<int>();
    for (const auto& [key, nu] : {std::pair{"nu_0.15", 0.15}, std::pair{"nu_0.45", 0.45},
                                  std::pair{"nu_0.499", 0.499}}) {
      const double expected = row.at("mean_tip_deflection").at(key).get<double>();
      const auto [nodes, loaded] = tip_deflection(Element::kTet4, Law::kLinear, cells, nu);
      std::printf("%d %s %.15g nodes %.15g loaded %.15g\n", cells, key, expected, nodes, loaded);
    }
  }
  const double theory = reference->at("expected").at("beam_theory").get<double>();
  for (const int cells : {1, 2}) {
    for (const double nu : {0.15, 0.499, 0.5}) {
    const auto [nodes, loaded] = tip_deflection(Element::kTet10, Law::kLinear, cells, nu);
    std::printf("%d %g theory %.8g nodes %.8g %.8g\n", cells, nu, theory, nodes, loaded);
    }
  }
}

}  // namespace
}  // namespace palpate
