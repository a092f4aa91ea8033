#include "slave/simulator/fingertips/pressed_body.h"

#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "slave/simulator/fingertips/finger_hand.h"
#include "slave/simulator/fingertips/site_mesh.h"
#include "slave/simulator/fingertips/true_object.h"

namespace palpate::simulation {
namespace {

using Eigen::Vector3d;

constexpr double kFoamYoung = 3800, kFoamPoisson = 0.15, kFoamRadius = 7e-3;

PressedBody::Held HeldBelow(const SiteMesh& mesh) {
  PressedBody::Held held;
  for (const auto& p : mesh.nodes) {
    const bool below = p.z() == 0;
    held.push_back({below, below, below});
  }
  return held;
}

SiteMesh CubeMesh(const Vector3d& size, const Vector3d& focus, const SiteResolution& resolution) {
  std::array<std::vector<double>, 3> axes;
  for (int a = 0; a < 3; ++a) {
    axes[static_cast<std::size_t>(a)] = GradedAxis({size[a], {focus[a]}, {}}, resolution);
  }
  return MeshGradedBox(axes);
}

// A 60 mm cube and a fingertip above the centre of the top, with its half sphere lowest.
struct CubePress {
  explicit CubePress(const SiteResolution& resolution, double young_modulus = kFoamYoung)
      : mesh(CubeMesh(Vector3d::Constant(0.06), {0.03, 0.03, 0.06}, resolution)),
        body(mesh, HeldBelow(mesh), young_modulus, kFoamPoisson, kFoamRadius) {}
  bool To(double depth) {
    FingerPlacement finger;
    finger.X_OF.linear() = Eigen::AngleAxisd(0.7, Vector3d::UnitY()).toRotationMatrix();
    finger.X_OF.translation() = Vector3d(0.03, 0.03, 0.06 + kFoamRadius - depth);
    finger.approach_O = {0, 0, -1};
    return body.Press(std::array{finger});
  }
  SiteMesh mesh;
  PressedBody body;
};

// Reference: Hertz 1882, F = 4/3 E / (1 - nu^2) sqrt(R d^3), a = sqrt(R d), a sphere on a half
// space without friction. A sticking contact is a few percent stiffer (a flat punch by 6 % at nu =
// 0.15, Spence 1968): 1.15, 1.08, 1.08 and 1.06 times Hertz here; a mesh of 9375 nodes gives 1.06,
// 1.08, 1.08 and 1.10.
TEST(PressedBody, PressesAreHertzianWithinTheMeshsError) {
  CubePress press({});
  for (const double depth : {0.5e-3, 1e-3, 2e-3, 3e-3}) {
    ASSERT_TRUE(press.To(depth));
    const FingerTouch touch = press.body.TouchOf(0);
    const double hertz = 4.0 / 3 * kFoamYoung / (1 - kFoamPoisson * kFoamPoisson) *
                         std::sqrt(kFoamRadius * std::pow(depth, 3));
    EXPECT_NEAR(-touch.force_O.z() / hertz, 1.08, 0.08) << depth;
    EXPECT_LT(touch.force_O.head<2>().norm(), 0.05 * -touch.force_O.z());
    EXPECT_NEAR(touch.radius, std::sqrt(kFoamRadius * depth), 0.12e-2) << depth;
    EXPECT_NEAR(touch.depth, depth, 1e-9);
  }
}

// Reference: the same press on a finer mesh. Measured: 42.0 mN with 5733 nodes, 42.2 with 2025 (the
// usual ones), 36.8 with 567.
TEST(PressedBody, ForceConvergesWithTheMesh) {
  const auto force = [](const SiteResolution& resolution) {
    CubePress press(resolution);
    EXPECT_TRUE(press.To(1e-3));
    EXPECT_TRUE(press.To(2e-3));
    return -press.body.TouchOf(0).force_O.z();
  };
  const double fine = force({.edge = 0.8e-3, .fine_reach = 3e-3, .growth = 0.5});
  EXPECT_NEAR(force({}) / fine, 1, 0.02);
  EXPECT_NEAR(force({.edge = 3.5e-3, .fine_reach = 4e-3, .growth = 0.8}) / fine, 1, 0.15);
}

// Reference: the same block of hexahedra. Tolerance: its surface has nodes 1 mm apart, that of
// cubic tetrahedra 2.2 mm: 2.6 % measured.
TEST(PressedBody, CubicTetrahedraAgreeWithHexahedra) {
  const Vector3d size = Vector3d::Constant(0.02), middle(0.01, 0.01, 0.02);
  const auto force = [&](const SiteMesh& mesh) {
    PressedBody body(mesh, HeldBelow(mesh), kFoamYoung, kFoamPoisson, kFoamRadius);
    FingerPlacement finger;
    finger.approach_O = {0, 0, -1};
    for (const double depth : {1e-3, 2e-3, 3e-3}) {
      finger.X_OF.translation() = middle + Vector3d(0, 0, kFoamRadius - depth);
      EXPECT_TRUE(body.Press(std::array{finger}));
    }
    return -body.TouchOf(0).force_O.z();
  };
  const SiteMesh tets = MeshTetrahedra(MeshBox(size, {3, 3, 3}), 20000);
  const SiteMesh hexes = CubeMesh(size, middle, {});
  EXPECT_NEAR(force(tets) / force(hexes), 1, 0.05);
}

double VolumeOf(const SiteMesh& mesh) {
  double volume = 0;
  Eigen::MatrixXd places(3, mesh.shape->nodes());
  for (const auto& nodes : mesh.elements) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      places.col(static_cast<int>(i)) = mesh.nodes[static_cast<std::size_t>(nodes[i])];
    }
    volume += PlacedElement(*mesh.shape, places, nodes).weights.sum();
  }
  return volume;
}

double VolumeInside(const SiteMesh& mesh) {
  double volume = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto& p = mesh.nodes;
    volume += p[static_cast<std::size_t>(a)].dot(
                  p[static_cast<std::size_t>(b)].cross(p[static_cast<std::size_t>(c)])) /
              6;
  }
  return volume;
}

// An element that overlaps or is turned inside out would throw or add to the volume.
TEST(SiteMesh, ElementsFillWhatTheSurfaceEncloses) {
  const Vector3d size(0.08, 0.05, 0.02);
  const SolidMesh tets = MeshBox(size, {3, 2, 1});
  for (const SiteMesh& mesh : {CubeMesh(size, {0.06, 0.025, 0.02}, {}), MeshTetrahedra(tets, 20000),
                               MeshTetrahedra(tets, 500)}) {
    EXPECT_NEAR(VolumeOf(mesh), size.prod(), 1e-12 * size.prod());
    EXPECT_NEAR(VolumeInside(mesh), size.prod(), 1e-12 * size.prod());
  }
}

}  // namespace
}  // namespace palpate::simulation
