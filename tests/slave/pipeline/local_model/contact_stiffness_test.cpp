#include "slave/pipeline/local_model/contact_stiffness.h"

#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/factory/make_model.h"
#include "tests/slave/pipeline/fingertips/tactile_scene.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing_fakes::CubeScene;
using testing_fakes::kAbove;

constexpr double kSoftE = 4000, kSoftNu = 0.15;

// The triangle whose centroid lies nearest to `p_O`.
int TriangleAt(const SurfaceMesh& surface, const Vector3d& p_O) {
  int best = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    const auto& [a, b, c] = surface.triangles[static_cast<std::size_t>(t)];
    const auto node = [&](int i) { return surface.nodes[static_cast<std::size_t>(i)]; };
    const double d = ((node(a) + node(b) + node(c)) / 3 - p_O).norm();
    if (d < nearest) nearest = d, best = t;
  }
  return best;
}

Matrix3d OnBox(const Vector3d& size, const std::array<int, 3>& cells, const Vector3d& p_O,
               double radius) {
  Scene scene = CubeScene(kAbove);
  scene.object.geometry = BoxGeometry{size, cells};
  const SolidMesh mesh = MeshBox(size, cells);
  const SurfaceMesh surface = SurfaceOf(mesh);
  ContactStiffness stiffness(scene, surface, &mesh);
  return stiffness.At(TriangleAt(surface, p_O), Vector3d::Constant(1.0 / 3), radius);
}

// Reference: Hertz's F = 4/3 E / (1 - nu^2) R^1/2 d^3/2 from the disc's own law, F = 2 E* a d.
TEST(ContactStiffnessTest, ADiscTakesTheForceOfTheSphere) {
  const double R = 7e-3, d = 2e-3, E_star = kSoftE / (1 - kSoftNu * kSoftNu);
  const double a = DiscOfSphere(R, d);
  Material material{kSoftE, kSoftNu, 45, 0};
  const double K = DiscStiffness(material, a, Vector3d::UnitZ())(2, 2);
  EXPECT_NEAR(K * d, 4.0 / 3 * E_star * std::sqrt(R) * std::pow(d, 1.5), 1e-12);
}

// Reference: the half-space. The block is 16 times as wide as the disc: its sides and its bottom
// change the compliance by about a / L = 6 %, its 10 mm tetrahedra the patch's by as much again.
TEST(ContactStiffnessTest, AWideBlockIsNearlyAHalfSpace) {
  const Vector3d size(0.16, 0.16, 0.08);
  const double a = 5e-3;
  const Matrix3d K = OnBox(size, {16, 16, 8}, {0.08, 0.08, 0.08}, a);
  const Matrix3d half_space = DiscStiffness({kSoftE, kSoftNu, 45, 0}, a, Vector3d::UnitZ());
  EXPECT_NEAR(K(2, 2) / half_space(2, 2), 1, 0.12);
  EXPECT_NEAR(K(0, 0) / half_space(0, 0), 1, 0.12);
}

// Two patches on opposite sides of a cube are pressed towards each other. Reference: both together,
// by the corotational solver; tolerance: the difference of both corrections for the mesh. A patch
// alone differs by the tilt of the cube. Moved in one direction, the other tool lets go of it.
TEST(ContactStiffnessTest, AnotherFingerIncreasesTheStiffness) {
  Scene scene = CubeScene(kAbove);
  constexpr double kSize = 0.06, kDeep = 0.057, kFar = 1e-5;
  // Seven nodes, which are as stiff as the disc (PatchStiffness: 1.0015): no model corrects these.
  constexpr double kWidth = 0.02016;
  scene.object.geometry = BoxGeometry{{kSize, kDeep, kSize}, {6, 12, 6}};
  scene.model.kind = "fem";
  const SolidMesh mesh = MeshBox({kSize, kDeep, kSize}, {6, 12, 6});
  const SurfaceMesh surface = SurfaceOf(mesh);
  const Vector3d right(kSize, kDeep / 2, 0.04), left(0, kDeep / 2, 0.04), along(-1, 0, 0);
  const int at_right = FindPlace(surface, right)->triangle;
  const int at_left = FindPlace(surface, left)->triangle;
  Vector3d weights(0, 0, 0);  // of the node there
  for (std::size_t k = 0; k < 3; ++k) {
    const int node = surface.triangles[static_cast<std::size_t>(at_right)][k];
    const auto& p_O = surface.nodes[static_cast<std::size_t>(node)];
    if ((p_O - right).norm() < 1e-9) weights[static_cast<int>(k)] = 1;
  }
  constexpr double kAsThePatch = 1;  // [m]; a wider contact uses the mesh alone
  ContactStiffness single(scene, surface, &mesh);
  const Vector3d alone = single.At(at_right, weights, kAsThePatch) * along;
  for (const double sense : {-1.0}) {
    ContactStiffness stiffness(scene, surface, &mesh, {{at_left, left, sense}});
    const Vector3d together = stiffness.At(at_right, weights, kAsThePatch) * along;
    const auto model = MakeModel(scene, mesh);
    std::array<Contact, 2> contacts;
    std::array<ContactResponse, 2> responses;
    for (std::size_t i = 0; i < 2; ++i) {
      contacts[i] = {.p_O = i == 0 ? right : left, .width = kWidth};
      contacts[i].prescribed_O = (i == 0 ? 1 : sense) * kFar * along;
    }
    model->Respond(contacts, responses);
    const Vector3d truth = responses[0].force_O / kFar;
    EXPECT_LT((together - truth).norm(), 0.02 * truth.norm()) << sense;
    EXPECT_GT((alone - truth).norm(), 0.2 * truth.norm()) << sense;
  }
}

}  // namespace
}  // namespace palpate
