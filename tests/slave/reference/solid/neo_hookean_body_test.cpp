#include "slave/reference/solid/neo_hookean_body.h"

#include <array>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/reference/reference_file.h"

namespace palpate::simulation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// A box of quadratic or cubic hexahedra, its lower corner at the origin.
struct Grid {
  Grid(const Vector3d& size, const std::array<int, 3>& hexahedra, int degree)
      : shape(ElementShape::Cube(3, degree)) {
    for (std::size_t a = 0; a < 3; ++a) lines[a] = degree * hexahedra[a] + 1;
    for (int k = 0; k < lines[2]; ++k) {
      for (int j = 0; j < lines[1]; ++j) {
        for (int i = 0; i < lines[0]; ++i) {
          nodes.emplace_back(size[0] * i / (lines[0] - 1), size[1] * j / (lines[1] - 1),
                             size[2] * k / (lines[2] - 1));
        }
      }
    }
    for (int k = 0; k + 1 < lines[2]; k += degree) {
      for (int j = 0; j + 1 < lines[1]; j += degree) {
        for (int i = 0; i + 1 < lines[0]; i += degree) Add(i, j, k);
      }
    }
  }
  void Add(int i, int j, int k) {
    std::vector<int> numbers;
    Eigen::MatrixXd places(3, shape.nodes());
    for (const auto& step : shape.lattice.colwise()) {
      const int n = number(i + step[0], j + step[1], k + step[2]);
      places.col(static_cast<int>(numbers.size())) = nodes[static_cast<std::size_t>(n)];
      numbers.push_back(n);
    }
    elements.emplace_back(shape, places, numbers);
  }
  [[nodiscard]] int number(int i, int j, int k) const { return i + lines[0] * (j + lines[1] * k); }
  [[nodiscard]] int count() const { return static_cast<int>(nodes.size()); }

  ElementShape shape;
  std::array<int, 3> lines{};
  std::vector<Vector3d> nodes;
  std::vector<PlacedElement> elements;
};

VectorXd RandomField(int size, double scale) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  VectorXd v(size);
  for (auto& x : v) x = scale * normal(random);
  return v;
}

TEST(NeoHookeanBody, StiffnessIsTheDerivativeOfTheForces) {
  const Grid grid({1, 0.8, 1.2}, {1, 1, 1}, 3);
  const NeoHookeanBody body(grid.elements, grid.count() - 2, NeoHookean(0.4, 0));
  NeoHookeanBody::Matrix stiffness = body.EmptyMatrix();
  const VectorXd u = RandomField(body.size(), 0.005), v = RandomField(body.size(), 1);
  VectorXd forces, up, down;
  ASSERT_TRUE(body.Linearise(u, &forces, &stiffness));
  const double h = 1e-6;  // truncation and rounding: 1e-9
  ASSERT_TRUE(body.Forces(u + h * v, &up) && body.Forces(u - h * v, &down));
  const VectorXd expected = (up - down) / (2 * h);
  EXPECT_LT((stiffness.selfadjointView<Eigen::Upper>() * v - expected).norm(),
            1e-7 * expected.norm());
}

// A quarter of the foam cube under a uniform dead load at the centre of its top, normalised by E
// and the side.
class SolvedCube {
 public:
  explicit SolvedCube(int half)
      : grid_({0.5, 0.5, 1}, {half, half, 2 * half}, 2),
        body_(grid_.elements, grid_.count(), NeoHookean(0.15, 0)),
        free_(VectorXd::Ones(body_.size())),
        load_(VectorXd::Zero(body_.size())),
        u_(load_) {
    for (int n = 0; n < grid_.count(); ++n) {
      const Vector3d& p = grid_.nodes[static_cast<std::size_t>(n)];
      for (int c = 0; c < 3; ++c) {
        if (p.z() == 0 || (c < 2 && p[c] == 0)) free_[3 * n + c] = 0;
      }
    }
    AddLoad(half);
  }

  // Solves for `load` [E side^2] on the whole cube, starting at the present deformation.
  bool Carry(double load) {
    NeoHookeanBody::Matrix stiffness = body_.EmptyMatrix();
    SparseLdlt<double> factor(stiffness);
    factor.Allocate(stiffness);
    VectorXd forces;
    for (int step = 0; step < 12; ++step) {
      if (!body_.Linearise(u_, &forces, &stiffness)) return false;
      VectorXd left = (load * load_ - forces).cwiseProduct(free_);
      if (left.norm() < 1e-9 * load * load_.norm()) return true;
      NeoHookeanBody::Hold(free_, &stiffness);
      if (!factor.Factorize(stiffness, true)) return false;
      factor.Solve(&left);
      u_ += left;
    }
    return false;
  }
  [[nodiscard]] Vector3d TopCentre() const { return At(0); }
  [[nodiscard]] Vector3d Corner() const { return At(grid_.lines[0] - 1); }

 private:
  [[nodiscard]] Vector3d At(int line) const {
    return u_.segment<3>(3 * grid_.number(line, line, grid_.lines[2] - 1));
  }
  // Applies the load to the square that extends a sixth of the side in each direction from the
  // centre.
  void AddLoad(int half) {
    const ElementShape face = ElementShape::Cube(2, 2);
    const Eigen::VectorXd shares = face.values * face.weights;
    const int loaded = half / 3;
    for (int i = 0; i < loaded; ++i) {
      for (int j = 0; j < loaded; ++j) {
        for (int n = 0; n < face.nodes(); ++n) {
          const int node = grid_.number(2 * i + face.lattice(0, n), 2 * j + face.lattice(1, n),
                                        grid_.lines[2] - 1);
          load_[3 * node + 2] -= shares[n] / (4 * loaded * loaded);
        }
      }
    }
  }

  Grid grid_;
  NeoHookeanBody body_;
  VectorXd free_, load_, u_;
};

// Loads the cube with a part of the load of a CalculiX case and compares.
void ExpectCalculix(SolvedCube* cube, const reference::json& file, const std::string& fraction,
                    double tolerance) {
  const double side = 0.06;
  ASSERT_TRUE(cube->Carry(std::stod(fraction) / (3800 * side * side))) << fraction;
  const auto all = reference::CaseOf(file, "cube_nlgeom_neo_fraction" + fraction)["expected"];
  const double centre = all.back()["u_top_centre"][2], corner = all.back()["u_corner"][2];
  EXPECT_NEAR(side * cube->TopCentre().z() / centre, 1, tolerance) << fraction;
  EXPECT_NEAR(side * cube->Corner().z() / corner, 1, tolerance) << fraction;
}

// Reference: CalculiX 2.20, hexahedra with 20 nodes, edges of a twelfth of the side. CalculiX
// converged at the full load only with edges of a sixth, which is 1 to 2 % stiffer at smaller
// loads.
TEST(NeoHookeanBody, CubeUnderADeadLoadDeformsAsInCalculix) {
  PALPATE_REFERENCE_OR_SKIP(file, "h_calculix.json");
  SolvedCube cube(6), coarse(3);
  ExpectCalculix(&cube, file, "0.25", 0.005);
  ExpectCalculix(&coarse, file, "0.25", 0.02);
  ASSERT_TRUE(coarse.Carry(0.5 / (3800 * 0.06 * 0.06)));  // an intermediate load
  ExpectCalculix(&coarse, file, "1", 0.02);
}

}  // namespace
}  // namespace palpate::simulation
