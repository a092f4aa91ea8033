// Tests regions of a volume with other moduli, in every kind of model that supports them.
#include <array>
#include <string>
#include <variant>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/mesh_resolution.h"
#include "slave/mechanics/object_mesh.h"
#include "tests/slave/mechanics/contacts.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using Element = FemOptions::Element;
using Law = FemOptions::Law;

constexpr double kRegionModulus = 20e3;  // [Pa]
constexpr double kFar = 1;               // [m]: beyond every body here

struct RegionKind {
  std::string kind;
  FemOptions::Law law = Law::kCorotational;
  FemOptions::Element element = Element::kTet4;
};
const std::vector<RegionKind> kKinds{{"fem"},
                                     {"fem", Law::kLinear},
                                     {"fem", Law::kLinear, Element::kTet10},
                                     {"fem", Law::kNeoHookean},
                                     {"fem", Law::kNeoHookean, Element::kTet10},
                                     {"fem-green"}};

std::string NameOfKind(const RegionKind& k) {
  return k.kind + (k.law == Law::kLinear ? " linear" : "") +
         (k.law == Law::kNeoHookean ? " neo-hookean" : "") +
         (k.element == Element::kTet10 ? " tet10" : "");
}

Scene BoxScene(const RegionKind& k, const BoxGeometry& box, double nu) {
  Scene scene;
  scene.object.geometry = box;
  scene.object.material = {.young_modulus = kRegionModulus, .poisson_ratio = nu};
  scene.object.fixed = {{FixedPlane{2, 0}}};
  scene.model.kind = k.kind;
  scene.model.range = 0.1;
  scene.model.fem.law = k.law;
  scene.model.fem.element = k.element;
  scene.model.fem.residual = 1e-10;
  return scene;
}

Region Layer(double from, double to, double modulus) {
  return {Eigen::AlignedBox3d(Vector3d(-kFar, -kFar, from), Vector3d(kFar, kFar, to)), modulus};
}

ContactResponse PressOnce(const Scene& scene, const Contact& contact) {
  const auto model = MakeModel(scene, MeshObject(scene, std::nullopt));
  const ContactResponse response = contacts::Answer(*model, contact);
  EXPECT_NE(response.validity, Validity::kFailed) << model->failure();
  return response;
}

// Between rollers a layered column is in uniaxial strain, which elements represent exactly: the
// layers act as springs in series, K = A / sum(h / M), M = E (1 - nu) / ((1 + nu) (1 - 2 nu)).
// Large-strain laws deviate by the strain, 1e-4 on average. The strain jumps between the layers,
// which must not be reported as an error of the mesh.
TEST(Regions, LayersOfAColumnAreSpringsInSeries) {
  const double nu = 0.3, side = 0.01, height = 0.04, by = 1e-4 * height;
  const std::array moduli{kRegionModulus, 5 * kRegionModulus, kRegionModulus, 0.2 * kRegionModulus};
  double softness = 0;
  for (const double E : moduli) {
    softness += (height / 4) * (1 + nu) * (1 - 2 * nu) / (E * (1 - nu));
  }
  for (const RegionKind& kind : kKinds) {
    Scene scene = BoxScene(kind, {{side, side, height}, {2, 2, 8}}, nu);
    scene.model.fem.residual = 1e-8;
    scene.object.regions = {Layer(height / 4, height / 2, moduli[1]),
                            Layer(3 * height / 4, height, moduli[3])};
    for (const double at : {0.0, side}) {
      scene.object.fixed.push_back({FixedPlane{0, at}, {true, false, false}});
      scene.object.fixed.push_back({FixedPlane{1, at}, {false, true, false}});
    }
    const ContactResponse response = PressOnce(
        scene,
        {.p_O = {side / 2, side / 2, height}, .width = 3 * side, .prescribed_O = {0, 0, -by}});
    EXPECT_NEAR(-response.force_O.z() * softness / (side * side * by), 1, 1e-4) << NameOfKind(kind);
    EXPECT_NE(response.flag_reason, kStiffInBending) << NameOfKind(kind);
  }
}

// Two equal objects: in one the part is a region with another modulus, in the other the rest of the
// body is the region.
TEST(Regions, WhichPartIsTheRegionDoesNotMatter) {
  const Contact contact{.p_O = {0.02, 0.02, 0.02}, .prescribed_O = {0, 0, -1e-3}};
  for (const RegionKind& kind : kKinds) {
    const double nu = kind.element == Element::kTet10 ? 0.495 : 0.45;  // ten nodes: with a pressure
    Scene lower = BoxScene(kind, {{0.04, 0.04, 0.02}, {4, 4, 4}}, nu), upper = lower;
    lower.object.regions = {Layer(-kFar, 0.01, 3 * kRegionModulus)};
    upper.object.material.young_modulus = 3 * kRegionModulus;
    upper.object.regions = {Layer(0.01, kFar, kRegionModulus)};
    const Vector3d force = PressOnce(lower, contact).force_O;
    EXPECT_LT((PressOnce(upper, contact).force_O - force).norm(), 1e-6 * force.norm())
        << NameOfKind(kind);
  }
}

Scene InclusionScene(const RegionKind& kind) {
  Scene scene = BoxScene(kind, {{0.06, 0.04, 0.025}, {24, 16, 10}}, 0.35);
  scene.model.fem.residual = 1e-6;
  scene.object.regions = {{Ball{{0.02, 0.02, 0.015}, 0.005}, 5 * kRegionModulus}};
  return scene;
}

// Forces of a scan across an inclusion of 10 mm whose top is 5 mm deep, relative to the force
// farthest away.
std::vector<double> Contrast(const Scene& scene) {
  const auto model = MakeModel(scene, MeshObject(scene, std::nullopt));
  std::vector<double> force;
  for (const double x : {0.02, 0.025, 0.03, 0.045}) {
    model->Reset();
    const ContactResponse response =
        contacts::Answer(*model, contacts::Move({x, 0.02, 0.025}, {0, 0, -0.001}, 0.01));
    EXPECT_EQ(response.validity, Validity::kValid) << response.flag_reason;
    force.push_back(-response.force_O.z());
  }
  for (double& f : force) f /= force.back();
  return force;
}

// Reference: the large-strain law on the same mesh, which does not use superposition. The bound is
// relative to the contrast minus one.
TEST(Regions, AnInclusionRaisesTheForceAsInTheFullModel) {
  const auto truth = Contrast(InclusionScene({"fem", Law::kNeoHookean}));
  EXPECT_GT(truth.front(), 1.15);  // there is a contrast
  for (const RegionKind& kind : {RegionKind{"fem-green"}, RegionKind{"fem"}}) {
    const auto contrast = Contrast(InclusionScene(kind));
    for (std::size_t i = 0; i < truth.size(); ++i) {
      EXPECT_NEAR(contrast[i], truth[i], 0.05 * truth[i]) << NameOfKind(kind) << " at " << i;
    }
  }
}

TEST(Regions, StoredGreensFunctionsAreThoseOfTheRegions) {
  const Scratch folder;
  const Contact contact{.p_O = {0.02, 0.02, 0.02}, .prescribed_O = {0, 0, -1e-3}};
  Scene scene = BoxScene({"fem-green"}, {{0.04, 0.04, 0.02}, {4, 4, 4}}, 0.45);
  Scene stored = scene;
  stored.model.cache = folder.path();
  PressOnce(stored, contact);
  scene.object.regions = stored.object.regions = {Layer(-kFar, 0.01, 3 * kRegionModulus)};
  EXPECT_EQ(PressOnce(stored, contact).force_O, PressOnce(scene, contact).force_O);
}

TEST(Regions, ATetrahedronBelongsToTheLastRegionThatContainsItsCentroid) {
  Scene scene = BoxScene({"fem"}, {{0.04, 0.04, 0.02}, {4, 4, 2}}, 0.45);
  scene.object.regions = {
      Layer(0.01, 0.02, 2 * kRegionModulus),
      {Eigen::AlignedBox3d(Vector3d(0, 0, 0), Vector3d(0.02, 1, 1)), kRegionModulus},
      {Ball{{0.04, 0.04, 0}, 0.0101}, 7 * kRegionModulus}};
  for (const int refinements : {0, 1}) {
    scene.model.refinements = refinements;
    const auto mesh = std::get<SolidMesh>(MeshObject(scene, std::nullopt));
    ASSERT_EQ(mesh.modulus.size(), mesh.tets.size());
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      Vector3d p(0, 0, 0);
      for (const int node : mesh.tets[t]) p += mesh.nodes[static_cast<std::size_t>(node)] / 4;
      const bool in_ball = (p - Vector3d(0.04, 0.04, 0)).norm() < 0.0101;
      EXPECT_EQ(mesh.modulus[t], in_ball ? 7 : p.x() > 0.02 && p.z() > 0.01 ? 2 : 1);
    }
  }
}

TEST(Regions, ARegionWithoutATetrahedronIsRefusedByItsLine) {
  Scene scene = BoxScene({"fem"}, {{0.04, 0.04, 0.02}, {4, 4, 2}}, 0.45);
  scene.file = "organ.yaml";
  scene.object.regions = {Layer(0.01, 0.02, 2 * kRegionModulus),
                          {Ball{{0.02, 0.02, 0.01}, 1e-4}, 7 * kRegionModulus, 12}};
  const std::string what = Thrown<std::invalid_argument>([&] { MeshObject(scene, std::nullopt); });
  EXPECT_THAT(what, HasSubstr("organ.yaml:12: object.regions.1: expected"));
}

}  // namespace
}  // namespace palpate
