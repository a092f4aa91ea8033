#include "slave/mechanics/fem/green/rest_stiffness.h"

#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "slave/mechanics/fem/green/green_columns.h"
#include "tests/slave/mechanics/direct_solution.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using Element = FemOptions::Element;

constexpr double kSide = 1, kLength = 2;  // of the bar, along z [m]
constexpr double kCurvature = 0.3;        // [1/m]

// Pure bending of a bar with nu = 0, clamped on z = 0: solves the equations of elasticity and the
// clamping exactly; stress E kappa (x - 1/2) along z and nothing else.
Vector3d Bent(const Vector3d& p) {
  return {-kCurvature * p.z() * p.z() / 2, 0, kCurvature * (p.x() - kSide / 2) * p.z()};
}

Body Bar(int cells, double nu) {
  return Standing(MeshBox({kSide, kSide, kLength}, {cells, cells, 2 * cells}), 2, 1, nu);
}

template <typename Field>
VectorXd AtRows(const RestStiffness& stiffness, Field field) {
  VectorXd values = VectorXd::Zero(stiffness.lower.rows());
  for (std::size_t n = 0; n < stiffness.row.size(); ++n) {
    for (int c = 0; c < 3; ++c) {
      const int row = stiffness.row[n][static_cast<std::size_t>(c)];
      if (row >= 0) values[row] = field(kLength * stiffness.elements.nodes[n])[c];
    }
  }
  return values;
}

// Law: a field in equilibrium needs no forces inside. Constant strain for tet4, linear for tet10,
// which is what the order of convergence rests on; energies to the closed form.
TEST(RestStiffness, PassesThePatchTestOfItsOrder) {
  for (const Element element : {Element::kTet4, Element::kTet10}) {
    const bool quadratic = element == Element::kTet10;
    const Body body = Bar(2, quadratic ? 0 : 0.3);
    const RestStiffness stiffness = AssembleAtRest(body.mesh, body.held, body.nu, element);
    EXPECT_EQ(stiffness.length_unit, kLength);
    const auto shear = [](const Vector3d& p) -> Vector3d { return p.z() * Vector3d(1, -2, 3); };
    const VectorXd u = quadratic ? AtRows(stiffness, Bent) : AtRows(stiffness, shear);
    const VectorXd f = stiffness.lower.selfadjointView<Eigen::Lower>() * u;
    const double largest = f.cwiseAbs().maxCoeff();
    int inside = 0;
    for (std::size_t n = 0; n < stiffness.row.size(); ++n) {
      const Vector3d p = kLength * stiffness.elements.nodes[n];
      const bool free_side = quadratic && p.z() < kLength - 1e-9;
      const bool within =
          std::min({p.x(), p.y(), kSide - p.x(), kSide - p.y(), kLength - p.z()}) > 1e-9;
      if (!(within || free_side)) continue;
      for (const int row : stiffness.row[n]) {
        if (row < 0) continue;
        ++inside;
        EXPECT_LT(std::abs(f[row]), 1e-13 * std::max(largest, 1.0));
      }
    }
    EXPECT_GT(inside, 0);
    // u^T K u = integral of E eps^2 (bending) or of mu (gx^2 + gy^2) + (lambda + 2 mu) gz^2.
    const double lambda = body.nu / ((1 + body.nu) * (1 - 2 * body.nu)), mu = 0.5 / (1 + body.nu);
    const double energy = quadratic ? kCurvature * kCurvature * kLength / 12
                                    : kLength * (5 * mu + 9 * (lambda + 2 * mu));
    EXPECT_NEAR(u.dot(f) * kLength, energy, 1e-12 * energy);  // K is scaled by the length unit
  }
}

// Reference: the bent bar. Loads are those of its end stress, integrated exactly. The error at the
// end falls with the square of the cells' size; measured orders 1.8 and 1.94.
TEST(RestStiffness, Tet4ConvergesWithTheSquareOfTheSize) {
  double before = 0;
  for (const int cells : {4, 8, 16}) {
    const Body body = Bar(cells, 0);
    const SurfaceMesh surface = SurfaceOf(body.mesh);
    GreenColumns columns(AssembleAtRest(body.mesh, body.held, 0, Element::kTet4), 1 << 20, {},
                         nullptr);
    std::map<int, double> load;
    for (const auto& triangle : surface.triangles) {
      std::array<double, 3> stress{};
      bool on_end = true;
      for (std::size_t v = 0; v < 3; ++v) {
        const Vector3d& p = surface.nodes[static_cast<std::size_t>(triangle[v])];
        stress[v] = kCurvature * (p.x() - kSide / 2);
        on_end = on_end && p.z() > kLength - 1e-9;
      }
      const double area = kSide * kSide / (2.0 * cells * cells);
      const double sum = stress[0] + stress[1] + stress[2];
      for (std::size_t v = 0; v < 3 && on_end; ++v) {
        load[triangle[v]] += area / 12 * (stress[v] + sum);
      }
    }
    std::vector<int> places;
    std::vector<Vector3d> forces, field;
    for (const auto& [node, force] : load) {
      places.push_back(columns.place_of_node()[static_cast<std::size_t>(node)]);
      forces.emplace_back(0, 0, force / (kLength * kLength));
    }
    columns.Solve(places, forces, &field);
    double error = 0;
    for (std::size_t n = 0; n < field.size(); ++n) {
      error = std::max(error, (kLength * field[n] - Bent(body.mesh.nodes[n])).norm());
    }
    if (before > 0) {
      EXPECT_NEAR(std::log2(before / error), 2, 0.35) << cells << " cells";
    }
    before = error;
  }
}

}  // namespace
}  // namespace palpate
