#include <random>

#include <gtest/gtest.h>

#include "slave/mechanics/capacitance/contact_set.h"
#include "tests/slave/mechanics/direct_solution.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

// Places all over the surface: on nodes, edges, inside triangles, a little off.
std::vector<Contact> Everywhere(const SurfaceMesh& surface) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Contact> contacts;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); t += 3) {
    const auto& nodes = surface.triangles[static_cast<std::size_t>(t)];
    Vector3d w(unit(random), unit(random), unit(random));
    if (t % 9 == 3) w = Vector3d::Unit(t % 3);
    w /= w.sum();
    Contact contact;
    for (int v = 0; v < 3; ++v) {
      contact.p_O +=
          w[v] * surface.nodes[static_cast<std::size_t>(nodes[static_cast<std::size_t>(v)])];
    }
    if (t % 9 == 6) contact.p_O += 1e-4 * Normal(surface, t);
    contacts.push_back(contact);
  }
  return contacts;
}

// Reference: PatchAt, which walks the surface without tables.
TEST(SurfaceFootprints, FindThePatchesThatPatchAtFinds) {
  const SurfaceMesh surface = SurfaceOf(ShakenBox({5, 4, 3}, 1, 0.3).mesh);
  SurfaceFootprints footprints(surface);
  ContactFootprint found;
  for (auto contact : Everywhere(surface)) {
    for (const double width : {0.004, 0.02, 0.05}) {
      contact.width = width;
      ASSERT_TRUE(footprints.OnNodes(contact, &found).empty());
      const DiscPatch patch = PatchAt(surface, found.at, contact.p_O, width);
      EXPECT_TRUE(std::ranges::equal(footprints.patch().nodes, patch.nodes)) << contact.p_O;
      EXPECT_TRUE(std::ranges::equal(footprints.patch().triangles, patch.triangles)) << contact.p_O;
    }
  }
}

// Two columns of 10 mm, the second 2 mm beside the first and 2 mm lower. The disc is wider than the
// first: it touches the whole top of the first column and no part of the other.
TEST(SurfaceFootprints, NothingBeyondAGapIsTouched) {
  constexpr double kSide = 0.010, kGap = 0.002;
  const SurfaceMesh column = SurfaceOf(MeshBox(Vector3d::Constant(kSide), {5, 5, 5}));
  SurfaceMesh both = column;
  const int count = static_cast<int>(column.nodes.size());
  for (const Vector3d& p : column.nodes) both.nodes.push_back(p + Vector3d(kSide + kGap, 0, -kGap));
  for (const auto& t : column.triangles) {
    both.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
  }
  const Contact contact{.p_O = {kSide / 2, kSide / 2, kSide}, .width = 2.4 * kSide};
  ContactFootprint found;
  SurfaceFootprints footprints(both);
  ASSERT_TRUE(footprints.OnNodes(contact, &found).empty());
  EXPECT_EQ(found.places.size(), 36U);
  EXPECT_NEAR(footprints.patch().disc.area, kSide * kSide, 1e-12);
  const DiscPatch patch = PatchAt(both, found.at, contact.p_O, contact.width);
  EXPECT_EQ(patch.nodes.size(), 36U);
  EXPECT_NEAR(patch.triangle_area, kSide * kSide, 1e-12);
}

TEST(SurfaceFootprints, ANamedTriangleGivesThePlaceThatTheWalkGives) {
  const SurfaceMesh surface = SurfaceOf(ShakenBox({5, 4, 3}, 1, 0.3).mesh);
  SurfaceFootprints footprints(surface);
  ContactFootprint walked, named;
  for (auto contact : Everywhere(surface)) {
    ASSERT_TRUE(footprints.OnNodes(contact, &walked).empty());
    contact.element = walked.at.triangle;
    ASSERT_TRUE(footprints.OnNodes(contact, &named).empty());
    EXPECT_EQ(named.at.node, walked.at.node);
    EXPECT_LT((named.at.weights - walked.at.weights).norm(), 1e-9);
    EXPECT_NEAR(named.at.distance, walked.at.distance, 1e-12);
    contact.p_O += Vector3d(1, 1, 1);
    EXPECT_FALSE(footprints.OnNodes(contact, &named).empty());
  }
}

}  // namespace
}  // namespace palpate
