// Frictionless contacts of volumes: linear, and along the normal only.
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "shared/mesh/disc_patch.h"
#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/factory/make_model.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Kind {
  std::string name;
  FemOptions::Element element = FemOptions::Element::kTet4;
  double width = 0;
};

// Tapered, slanted and turned: its sides are flat, and only the held one and the top are along
// axes.
SolidMesh Slanted() {
  SolidMesh mesh = MeshBox({0.06, 0.05, 0.04}, {4, 4, 3});
  for (Vector3d& p : mesh.nodes) {
    const double narrower = 1 - 8 * p.z();
    const Vector3d leant(narrower * p.x() + 0.2 * p.z(), narrower * p.y(), p.z());
    p = Eigen::AngleAxisd(0.3, Vector3d::UnitZ()) * leant;
  }
  return mesh;
}

class FrictionlessVolume : public testing::TestWithParam<Kind> {
 protected:
  FrictionlessVolume() {
    Scene scene;
    scene.object.geometry = BoxGeometry{{0.06, 0.05, 0.04}, {4, 4, 3}};
    scene.object.material = {.young_modulus = 5e4, .poisson_ratio = 0.4};
    scene.object.fixed = {Fixed{FixedPlane{2, 0}, {true, true, true}}};
    scene.model.kind = "fem-green";
    scene.model.contact = ContactLaw::kFrictionless;
    scene.model.fem.element = GetParam().element;
    scene.model.range = 1;
    const SolidMesh mesh = Slanted();
    const SurfaceMesh surface = SurfaceOf(mesh);
    model_ = MakeModel(scene, mesh);
    Vector3d middle(0, 0, 0);
    for (const Vector3d& p : mesh.nodes) middle += p / static_cast<double>(mesh.nodes.size());
    // On top and on two sides, away from what is held.
    for (const Vector3d& towards :
         {Vector3d(0, 0, 1), Vector3d(1, 0.3, 0.1), Vector3d(-1, -0.3, 0.1)}) {
      int best = 0;
      double most = -1;
      for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
        const Vector3d arm = (Centroid(surface, t) - middle).normalized();
        const double along = arm.dot(towards.normalized());
        if (along > most) best = t;
        most = std::max(most, along);
      }
      places_.push_back(Centroid(surface, best));
      normals_.push_back(Normal(surface, best));
    }
  }

  std::vector<ContactResponse> Move(const std::vector<Vector3d>& by,
                                    std::vector<Vector3d>* field = nullptr) {
    std::vector<Contact> contacts(by.size());
    for (std::size_t i = 0; i < by.size(); ++i) {
      contacts[i].p_O = places_[i];
      contacts[i].prescribed_O = by[i];
      contacts[i].width = GetParam().width;
    }
    Solution solution;
    model_->Solve(contacts, &solution);
    for (const ContactResponse& one : solution.responses()) {
      EXPECT_NE(one.validity, Validity::kFailed) << model_->failure();
    }
    if (field != nullptr) model_->Displacements(solution, field);
    return solution.responses();
  }

  std::unique_ptr<DeformationModel> model_;
  std::vector<Vector3d> places_, normals_;
};

// Law: linearity. The forces of contacts that move together, and the field around them, are the
// sums over the contacts of what each one does alone while the others rest.
TEST_P(FrictionlessVolume, SeparateContactsSuperpose) {
  const Vector3d none(0, 0, 0);
  std::vector<Vector3d> moved;
  for (const Vector3d& n : normals_) {
    moved.push_back(-1e-3 * n + 0.5e-3 * n.unitOrthogonal());
  }
  std::vector<Vector3d> field, sum_of_fields;
  const auto together = Move(moved, &field);
  Matrix3d forces, sum = Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) forces.col(i) = together[static_cast<std::size_t>(i)].force_O;
  sum_of_fields.assign(field.size(), none);
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<Vector3d> alone(3, none), part;
    alone[k] = moved[k];
    const auto responses = Move(alone, &part);
    for (int i = 0; i < 3; ++i) sum.col(i) += responses[static_cast<std::size_t>(i)].force_O;
    for (std::size_t n = 0; n < field.size(); ++n) sum_of_fields[n] += part[n];
  }
  EXPECT_GT(forces.col(1).norm(), 0.1 * forces.norm());
  EXPECT_LT((sum - forces).norm(), 1e-9 * forces.norm());
  for (std::size_t n = 0; n < field.size(); ++n) {
    EXPECT_LT((field[n] - sum_of_fields[n]).norm(), 1e-9 * 1e-3) << "node " << n;
  }
  // The others are no fixed points: a contact that rests is pushed.
  const auto beside = Move({moved[0], none, none});
  EXPECT_GT(beside[1].force_O.norm(), 1e-4 * beside[0].force_O.norm());
}

// Law: without friction there is no traction across the normal. A slanted displacement does what
// its part along the normal does.
TEST_P(FrictionlessVolume, ASlantedDisplacementHasNoForceAcrossTheNormal) {
  std::vector<Vector3d> straight, slanted;
  for (const Vector3d& n : normals_) {
    straight.push_back(-1e-3 * n);
    slanted.push_back(-1e-3 * n + 2e-3 * n.unitOrthogonal());
  }
  const auto plain = Move(straight), other = Move(slanted);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3d force = plain[i].force_O;
    EXPECT_GT(std::abs(normals_[i].dot(force)), 0) << i;
    EXPECT_LT((other[i].force_O - force).norm(), 1e-9 * force.norm()) << i;
    EXPECT_LT(normals_[i].cross(other[i].force_O).norm(), 1e-6 * force.norm()) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, FrictionlessVolume,
    testing::Values(Kind{"Node"}, Kind{"Patch", FemOptions::Element::kTet4, 0.014},
                    Kind{"TenNodes", FemOptions::Element::kTet10},
                    Kind{"PatchOfTenNodes", FemOptions::Element::kTet10, 0.014}),
    [](const auto& kind) { return kind.param.name; });

}  // namespace
}  // namespace palpate
