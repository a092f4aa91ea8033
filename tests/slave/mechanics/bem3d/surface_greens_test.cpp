#include "slave/mechanics/bem3d/surface_greens.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/mechanics/bem3d/solid_bodies.h"

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

double TensionError(int cells, double nu) {
  const SurfaceMesh mesh = solid_bodies::Box({1, 1, 1}, {cells, cells, cells});
  const SurfaceGreens greens(mesh, Rollers(mesh), nu, {});
  const auto u = Displacements(greens, [](const FlatTriangle& t) {
    return t.normal.z() > 0.5 ? Vector3d(0, 0, 1) : Vector3d(0, 0, 0);
  });
  return RelativeError(greens, u, [nu](const Vector3d& p) {
    const Vector3d from_corner = p + Vector3d::Constant(0.5);
    return Vector3d(-nu * from_corner.x(), -nu * from_corner.y(), from_corner.z());
  });
}

// Reference: Hooke's law under uniform tension. Constant elements are of first order.
TEST(SurfaceGreens, UniformTensionIsMetWithFirstOrder) {
  std::printf(
      "tension of a box, |u - exact| / |exact|\n  nu      2 cells   4 cells   6 cells   order\n");
  for (const double nu : {-0.9, -0.5, 0.0, 0.3, 0.49, 0.5}) {
    const double coarse = TensionError(2, nu);
    const double middle = TensionError(4, nu);
    const double fine = TensionError(6, nu);
    const double order = std::log(middle / fine) / std::log(6.0 / 4.0);
    std::printf("  %5.2f  %.2e  %.2e  %.2e   %.2f\n", nu, coarse, middle, fine, order);
    EXPECT_LT(fine, 0.03) << "nu = " << nu;
    EXPECT_GT(order, 0.8) << "nu = " << nu;
  }
}

double PressedSphereError(int parts, double nu) {
  const SurfaceMesh mesh = solid_bodies::Sphere(1, parts);
  const SurfaceGreens greens(mesh, solid_bodies::Free(mesh), nu, {});
  const auto u = Displacements(greens, [](const FlatTriangle& t) { return Vector3d(-t.normal); });
  return RelativeError(greens, u, [nu](const Vector3d& p) { return Vector3d(-(1 - 2 * nu) * p); });
}

// Reference: u = -p r (1 - 2 nu) / E, on a body that nothing holds: the pressure balances itself.
TEST(SurfaceGreens, PressedSphereShrinksEvenly) {
  std::printf(
      "pressed sphere, |u - exact| / |exact|\n  nu     80 tri.   180 tri.  320 tri.  order\n");
  for (const double nu : {-0.9, 0.0, 0.3, 0.45}) {
    const double coarse = PressedSphereError(2, nu);
    const double middle = PressedSphereError(3, nu);
    const double fine = PressedSphereError(4, nu);
    const double order = std::log(middle / fine) / std::log(4.0 / 3.0);
    std::printf("  %5.2f  %.2e  %.2e  %.2e  %.2f\n", nu, coarse, middle, fine, order);
    EXPECT_LT(fine, 0.15) << "nu = " << nu;
    EXPECT_GT(order, 0.8) << "nu = " << nu;
  }
}

// Reference: an incompressible body does not move under even pressure.
TEST(SurfaceGreens, IncompressibleSphereDoesNotMoveUnderPressure) {
  const SurfaceMesh mesh = solid_bodies::Sphere(1, 3);
  const SurfaceGreens greens(mesh, solid_bodies::Free(mesh), 0.5, {});
  for (const auto& u :
       Displacements(greens, [](const FlatTriangle& t) { return Vector3d(-t.normal); })) {
    EXPECT_LT(u.norm(), 1e-3);
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
// [ (1 - 2 nu) r + (1 + nu) b^3 / (2 r^2) ].
TEST(SurfaceGreens, ThickShellSwellsUnderInnerPressureAsLameSays) {
  std::printf("thick shell, |u - exact| / |exact|\n  nu     160 tri.  360 tri.  order\n");
  for (const double nu : {-0.5, 0.0, 0.3, 0.45, 0.49}) {
    const double coarse = ShellError(2, nu);
    const double fine = ShellError(3, nu);
    std::printf("  %5.2f  %.2e  %.2e  %.2f\n", nu, coarse, fine,
                std::log(coarse / fine) / std::log(1.5));
    EXPECT_LT(fine, 0.3) << "nu = " << nu;
    EXPECT_LT(fine, 0.8 * coarse) << "nu = " << nu;
  }
}

SurfaceMesh Block(int cells) {
  return solid_bodies::Box({1, 1, 1}, {cells, cells, cells});
}
Held Bottom(const SurfaceMesh& mesh) {
  return solid_bodies::HeldWhere(mesh, [](const Vector3d& p) { return p.z() < 1e-9; });
}

// Reference: a closed surface is crossed by no net flux of the kernels, so that H moves a rigid
// translation to nothing; with exact integrals that leaves rounding.
TEST(SurfaceGreens, SystemCarriesARigidTranslationExactly) {
  for (const double nu : {-0.9, 0.0, 0.3, 0.5}) {
    const SurfaceMesh mesh = solid_bodies::Sphere(1, 3);
    const ReferenceSystem system(mesh, solid_bodies::Free(mesh), nu);
    const auto H = system.Matrix([](int) {});
    for (int i = 0; i < system.triangles(); ++i) {
      Matrix3d sum = Matrix3d::Zero();
      for (int j = 0; j < system.triangles(); ++j) sum += H.block<3, 3>(3 * i, 3 * j);
      EXPECT_LT(sum.norm(), 1e-13) << "triangle " << i << ", nu = " << nu;
    }
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
  std::printf("reciprocity error: %.2e %.2e %.2e\n", coarse, middle, fine);
  EXPECT_LT(middle, coarse / 1.5);
  EXPECT_LT(fine, middle / 1.3);
  EXPECT_LT(fine, 0.05);
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
  std::printf("worst reaction error: %.2e %.2e\n", coarse, fine);
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
  try {
    SurfaceGreens greens(mesh, held, nu, options);
  } catch (const std::invalid_argument& refused) {
    return refused.what();
  }
  return "";
}

TEST(SurfaceGreens, RefuseWhatThePressureIsLostIn) {
  using ::testing::HasSubstr;
  const SurfaceMesh mesh = Block(1);
  const Held all = solid_bodies::HeldWhere(mesh, [](const Vector3d&) { return true; });
  EXPECT_THAT(Refusal(mesh, all, 0.5), HasSubstr("held on its whole surface"));
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
