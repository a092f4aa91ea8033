#include "slave/mechanics/bem3d/surface_greens.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/mechanics/bem3d/solid_bodies.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using solid_bodies::Held;

using Loading = std::function<Vector3d(const FlatTriangle&)>;  // traction over E

// Displacement of every triangle, nondimensional.
std::vector<Vector3d> Displacements(const SurfaceGreens& greens, const Loading& traction) {
  const auto& elements = greens.system().surface().elements;
  std::vector<Vector3d> u(elements.size(), Vector3d::Zero());
  for (std::size_t j = 0; j < elements.size(); ++j) {
    const Vector3d force = elements[j].area * traction(elements[j]);
    const double* column = greens.column(static_cast<int>(j));
    for (std::size_t i = 0; i < u.size(); ++i) {
      u[i] += Eigen::Map<const Matrix3d>(column + 9 * i) * force;
    }
  }
  return u;
}

// Root of the mean square over the surface of u - expected(p), relative to that of expected.
double RelativeError(const SurfaceGreens& greens, const std::vector<Vector3d>& u,
                     const std::function<Vector3d(const Vector3d&)>& expected) {
  const auto& elements = greens.system().surface().elements;
  double error = 0, size = 0;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const Vector3d want = expected(elements[i].centroid);
    error += elements[i].area * (u[i] - want).squaredNorm();
    size += elements[i].area * want.squaredNorm();
  }
  return std::sqrt(error / size);
}

// Held by smooth rollers on the three coordinate planes through the box's lower corner.
Held Rollers(const SurfaceMesh& mesh) {
  Held held;
  for (int i = 0; i < static_cast<int>(mesh.triangles.size()); ++i) {
    const Vector3d p = Centroid(mesh, i);
    held.push_back({p.x() < 1e-9, p.y() < 1e-9, p.z() < 1e-9});
  }
  return held;
}

// Reference: Hooke's law under uniform tension. What is linear in space is met exactly; the rest is
// rounding, which grows with G / K near nu = -1.
TEST(SurfaceGreens, UniformTensionIsMetExactly) {
  const SurfaceMesh mesh = solid_bodies::Box({1, 0.7, 1.3}, {2, 3, 4});
  for (const double nu : {-0.9, -0.5, 0.0, 0.3, 0.49, 0.5}) {
    const SurfaceGreens greens(mesh, Rollers(mesh), nu, {});
    const auto u = Displacements(greens, [](const FlatTriangle& t) {
      return t.normal.z() > 0.5 ? Vector3d(0, 0, 1) : Vector3d(0, 0, 0);
    });
    const Vector3d corner = Vector3d(0.5, 0.35, 0.65) / 1.3;
    const double error = RelativeError(greens, u, [&](const Vector3d& p) {
      const Vector3d q = p + corner;
      return Vector3d(-nu * q.x(), -nu * q.y(), q.z());
    });
    EXPECT_LT(error, 1e-12) << "nu = " << nu;
  }
}

// Reference: as above, on a body that nothing holds, with every component of stress; an
// icosahedron's symmetry leaves no mean turn of a pure strain.
TEST(SurfaceGreens, UniformStressOnAFreeBodyIsMetExactly) {
  Matrix3d stress;
  stress << 0.3, -0.2, 0.5, -0.2, 0.7, 0.1, 0.5, 0.1, -0.4;
  for (const double nu : {-0.9, 0.0, 0.3, 0.5}) {
    const SurfaceMesh mesh = solid_bodies::Sphere(1, 3);
    const SurfaceGreens greens(mesh, solid_bodies::Free(mesh), nu, {});
    const auto u =
        Displacements(greens, [&](const FlatTriangle& t) -> Vector3d { return stress * t.normal; });
    const Matrix3d strain = (1 + nu) * stress - nu * stress.trace() * Matrix3d::Identity();
    EXPECT_LT(RelativeError(greens, u, [&](const Vector3d& p) -> Vector3d { return strain * p; }),
              1e-12)
        << "nu = " << nu;
  }
}

// Takes away the rigid motion that is nearest to `u`, by area.
void RemoveRigidMotion(const SurfaceGreens& greens, std::vector<Vector3d>* u) {
  const auto& elements = greens.system().surface().elements;
  Eigen::Matrix<double, 6, 6> gram = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> moved = Eigen::Matrix<double, 6, 1>::Zero();
  for (std::size_t i = 0; i < u->size(); ++i) {
    const auto modes = greens.system().RigidModes(elements[i].centroid);
    gram += elements[i].area * modes.transpose() * modes;
    moved += elements[i].area * modes.transpose() * (*u)[i];
  }
  const Eigen::Matrix<double, 6, 1> amplitudes = gram.ldlt().solve(moved);
  for (std::size_t i = 0; i < u->size(); ++i) {
    (*u)[i] -= greens.system().RigidModes(elements[i].centroid) * amplitudes;
  }
}

double BendingError(int cells, double nu) {
  const SurfaceMesh mesh = solid_bodies::Box({2, 1, 1}, {2 * cells, cells, cells});
  const SurfaceGreens greens(mesh, solid_bodies::Free(mesh), nu, {});
  auto u = Displacements(greens, [](const FlatTriangle& t) {
    return Vector3d(std::abs(t.normal.x()) > 0.5 ? t.normal.x() * t.centroid.z() : 0, 0, 0);
  });
  const auto& elements = greens.system().surface().elements;
  std::vector<Vector3d> exact;
  for (const auto& t : elements) {
    const double x = t.centroid.x(), y = t.centroid.y(), z = t.centroid.z();
    exact.emplace_back(x * z, -nu * y * z, -0.5 * (x * x + nu * (z * z - y * y)));
  }
  RemoveRigidMotion(greens, &u);
  RemoveRigidMotion(greens, &exact);
  int i = 0;
  return RelativeError(greens, u,
                       [&](const Vector3d&) { return exact[static_cast<std::size_t>(i++)]; });
}

// Reference: Saint-Venant's pure bending, s_xx = E z, on a beam that nothing holds: displacements
// of second order in space. Linear displacements leave an error of second order; where the
// tractions vary, their steps add one that turns over from triangle to triangle.
TEST(SurfaceGreens, PureBendingIsMetWithSecondOrder) {
  for (const double nu : {-0.5, 0.3, 0.5}) {
    const double middle = BendingError(2, nu);
    const double fine = BendingError(3, nu);
    const double order = std::log(middle / fine) / std::log(1.5);
    EXPECT_LT(fine, 0.2) << "nu = " << nu;
    EXPECT_GT(order, 1.8) << "nu = " << nu;
  }
}

double ShellError(int parts, double nu) {
  const auto mesh =
      solid_bodies::WithCavity(solid_bodies::Sphere(2, parts), solid_bodies::Sphere(1, parts));
  const SurfaceGreens greens(mesh, solid_bodies::Free(mesh), nu, {});
  const double a = 0.25, b = 0.5;  // radii over the outer diameter
  const auto u = Displacements(greens, [](const FlatTriangle& t) {
    return t.centroid.norm() < 0.4 ? Vector3d(-t.normal) : Vector3d(0, 0, 0);
  });
  const double k = a * a * a / (b * b * b - a * a * a);
  return RelativeError(greens, u, [&](const Vector3d& p) {
    const double r = p.norm();
    return Vector3d(k * p * ((1 - 2 * nu) + (1 + nu) / 2 * b * b * b / (r * r * r)));
  });
}

// Reference: Lame's thick sphere under inner pressure p: u_r = p a^3 / (E (b^3 - a^3))
// [ (1 - 2 nu) r + (1 + nu) b^3 / (2 r^2) ]. The corners lie on the spheres, so the body is a
// little small too: (edge / radius)^2 / 6.
TEST(SurfaceGreens, ThickShellSwellsUnderInnerPressureAsLameSays) {
  for (const double nu : {-0.5, 0.0, 0.3, 0.4}) {
    const double coarse = ShellError(2, nu);
    const double fine = ShellError(3, nu);
    const double order = std::log(coarse / fine) / std::log(1.5);
    EXPECT_LT(fine, 0.04) << "nu = " << nu;
    EXPECT_GT(order, 1) << "nu = " << nu;
  }
}

SurfaceMesh Block(int cells) {
  return solid_bodies::Box({1, 1, 1}, {cells, cells, cells});
}
Held Bottom(const SurfaceMesh& mesh) {
  return solid_bodies::HeldWhere(mesh, [](const Vector3d& p) { return p.z() < 1e-9; });
}

// Reference: a closed surface is crossed by no net flux of the kernels, so that H moves a rigid
// translation to nothing; linear displacements do the same for a turn. That leaves rounding.
TEST(SurfaceGreens, SystemCarriesRigidMotionsExactly) {
  for (const double nu : {-0.9, 0.0, 0.3, 0.5}) {
    const SurfaceMesh mesh = solid_bodies::Sphere(1, 3);
    const ReferenceSystem system(mesh, solid_bodies::Free(mesh), nu);
    const Eigen::Index n = 3 * system.triangles();
    const auto H = system.Matrix([](int) {}).topLeftCorner(n, n).eval();
    Eigen::MatrixXd motions(n, 6);
    for (int i = 0; i < system.triangles(); ++i) {
      const auto& t = system.surface().elements[static_cast<std::size_t>(i)];
      motions.middleRows<3>(3 * i) = system.RigidModes(t.centroid);
    }
    EXPECT_LT((H * motions).cwiseAbs().maxCoeff(), 1e-13) << "nu = " << nu;
  }
}

double ReciprocityError(int cells) {
  const SurfaceMesh mesh = Block(cells);
  const SurfaceGreens greens(mesh, Bottom(mesh), 0.3, {});
  double error = 0, size = 0;
  for (int i = 0; i < greens.places(); ++i) {
    for (int j = 0; j < i; ++j) {
      const Eigen::Map<const Matrix3d> ij(greens.column(j) + 9 * i), ji(greens.column(i) + 9 * j);
      const double both = greens.system().surface().elements[static_cast<std::size_t>(i)].area *
                          greens.system().surface().elements[static_cast<std::size_t>(j)].area;
      error += both * (ij - ji.transpose()).squaredNorm();
      size += both * ij.squaredNorm();
    }
  }
  return std::sqrt(error / size);
}

// Reference: Betti's reciprocity, which collocation meets only as the mesh gets finer.
TEST(SurfaceGreens, BecomeSymmetric) {
  const double coarse = ReciprocityError(2);
  const double middle = ReciprocityError(4);
  const double fine = ReciprocityError(6);
  EXPECT_LT(middle, coarse / 1.5);
  EXPECT_LT(fine, middle / 1.3);
  EXPECT_LT(fine, 0.06);
}

double ReactionError(int cells) {
  const SurfaceMesh mesh = Block(cells);
  const SurfaceGreens greens(mesh, Bottom(mesh), 0.3, {});
  double worst = 0;
  for (int j = 0; j < greens.places(); ++j) {
    if (greens.system().held(j, 0)) continue;
    Matrix3d sum = Matrix3d::Zero();
    for (int i = 0; i < greens.places(); ++i) {
      const double area = greens.system().surface().elements[static_cast<std::size_t>(i)].area;
      for (int c = 0; c < 3; ++c) sum.col(c) += area * greens.Reaction(i, j, Vector3d::Unit(c));
    }
    worst = std::max(worst, (sum + Matrix3d::Identity()).norm());
  }
  return worst;
}

// Reference: equilibrium, which collocation meets only as the mesh gets finer.
TEST(SurfaceGreens, ReactionsBalanceEveryForceBetterAndBetter) {
  const double coarse = ReactionError(2);
  const double fine = ReactionError(4);
  EXPECT_LT(coarse, 0.5);
  EXPECT_LT(fine, coarse / 1.5);
}

// Reference: the same body in another unit; nothing but rounding may change.
TEST(SurfaceGreens, DoNotDependOnTheSizeOfTheBody) {
  const SurfaceMesh one = Block(2);
  const SurfaceGreens greens(one, Bottom(one), 0.3, {});
  for (const double size : {1e-9, 1e-3, 1e3}) {
    SurfaceMesh other = one;
    for (auto& p : other.nodes) p = size * (p + Vector3d(3, -2, 1));
    const SurfaceGreens scaled(other, Bottom(one), 0.3, {});
    for (int k = 0; k < 9 * greens.places() * greens.places(); ++k) {
      ASSERT_NEAR(greens.column(0)[k], scaled.column(0)[k], 1e-11) << "size " << size;
    }
    EXPECT_NEAR(scaled.length_unit() / size, 1, 1e-15);
  }
}

// Reference: the numbering of triangles means nothing.
TEST(SurfaceGreens, DoNotDependOnTheNumberingOfTriangles) {
  const SurfaceMesh mesh = Block(2);
  const Held held = Bottom(mesh);
  const int count = static_cast<int>(mesh.triangles.size());
  SurfaceMesh turned = mesh;
  Held turned_held = held;
  std::rotate(turned.triangles.begin(), turned.triangles.begin() + 13, turned.triangles.end());
  std::rotate(turned_held.begin(), turned_held.begin() + 13, turned_held.end());
  const SurfaceGreens one(mesh, held, 0.3, {});
  const SurfaceGreens other(turned, turned_held, 0.3, {});
  for (int j = 0; j < count; ++j) {
    for (int k = 0; k < 9 * count; ++k) {
      const int i = (k / 9 + 13) % count;
      EXPECT_NEAR(other.column(j)[k], one.column((j + 13) % count)[9 * i + k % 9], 1e-11);
    }
  }
}

std::string Refusal(const SurfaceMesh& mesh, const Held& held, double nu,
                    const SurfaceGreens::Options& options = {}) {
  return Thrown<std::invalid_argument>([&] { SurfaceGreens greens(mesh, held, nu, options); });
}

TEST(SurfaceGreens, RefuseWhatThePressureIsLostIn) {
  using ::testing::HasSubstr;
  const SurfaceMesh mesh = Block(1);
  const Held all = solid_bodies::HeldWhere(mesh, [](const Vector3d&) { return true; });
  EXPECT_THAT(Refusal(mesh, all, 0.5), HasSubstr("whose whole surface is fixed"));
  EXPECT_EQ(Refusal(mesh, Bottom(mesh), 0.5), "");
  const auto shell =
      solid_bodies::WithCavity(solid_bodies::Sphere(2, 1), solid_bodies::Sphere(1, 1));
  EXPECT_THAT(Refusal(shell, solid_bodies::Free(shell), 0.5), HasSubstr("with cavities"));
  for (const double nu : {-1.0, 0.51, std::nan("")}) {
    EXPECT_THAT(Refusal(mesh, Bottom(mesh), nu), HasSubstr("accepted is -1 < nu <= 0.5"));
  }
  EXPECT_THAT(Refusal(mesh, {}, 0.3), HasSubstr("boundary conditions for 0 of 12"));
  EXPECT_THAT(Refusal(mesh, Bottom(mesh), 0.3, {.cache = {}, .memory_limit = 1000}),
              HasSubstr("12 triangles need"));
}

// Reference: rigid kinematics. A held component takes away the motions that move its centroid.
TEST(SurfaceGreens, KnowWhichMotionsAreLeftFree) {
  const SurfaceMesh mesh = Block(2);
  const auto free_motions = [&](const Held& held) {
    return ReferenceSystem(mesh, held, 0.3).free_motions();
  };
  Held held = solid_bodies::Free(mesh);
  EXPECT_EQ(free_motions(held), 6);
  for (std::size_t i = 0; i < held.size(); ++i) {
    held[i][2] = Centroid(mesh, static_cast<int>(i)).z() < 1e-9;  // slides on the floor
  }
  EXPECT_EQ(free_motions(held), 3);
  held = solid_bodies::Free(mesh);
  held[0] = {true, true, true};
  EXPECT_EQ(free_motions(held), 3);
  EXPECT_EQ(free_motions(Rollers(mesh)), 0);
  EXPECT_EQ(free_motions(Bottom(mesh)), 0);
}

}  // namespace
}  // namespace palpate
