// Tests Ogden's law: derivatives by differences, the rest state, known special cases, and closed
// forms for a block under homogeneous load.
#include "slave/mechanics/fem/solid/ogden_law.h"

#include <cmath>
#include <random>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "slave/mechanics/fem/solid/material_law.h"
#include "tests/slave/mechanics/solid/bodies.h"

namespace palpate {
namespace {

using namespace solid_tests;  // NOLINT(google-build-using-namespace): its helpers are for here
using Eigen::Matrix3d;
using Eigen::Vector3d;

const std::vector<OgdenTerm> kNeo{{1, 2}};
const std::vector<OgdenTerm> kMooney{{0.75, 2}, {0.25, -2}};

TEST(OgdenLaw, InvertedPlacesHaveNoEnergy) {
  const OgdenLaw law(kRubber, 0.4);
  EXPECT_TRUE(std::isinf(law.At(Matrix3d(Vector3d(0, 0, -1.5).asDiagonal())).energy));
}

// Two equal stretches make the difference quotient of the tangent a derivative.
TEST(OgdenLaw, TangentIsSmoothWhereStretchesMeet) {
  const MaterialLaw law(Law::kOgden, 0.45, kRubber);
  const auto tangent = [&](double apart) {
    const Matrix3d H = Vector3d(0.4, -0.2, -0.2 + apart).asDiagonal();
    return law.TangentAt(H, 0.1, 0, kExactTangent);
  };
  EXPECT_LT((tangent(1e-5) - tangent(0)).norm(), 1e-3);
  EXPECT_LT((tangent(1e-7) - tangent(0)).norm(), 1e-5);
}

// The invariants of the deformation at equal volume, by products and not by stretches.
TEST(OgdenLaw, ExponentsOfTwoAreNeoHookeAndMooney) {
  std::mt19937 engine(2);
  const double mu = 0.5 / 1.45;
  for (int trial = 0; trial < 20; ++trial) {
    const Matrix3d H = Random(&engine, 0.3), F = Matrix3d::Identity() + H;
    const Matrix3d C = std::pow(F.determinant(), -2.0 / 3) * F.transpose() * F;
    const double I1 = C.trace(), I2 = 0.5 * (I1 * I1 - (C * C).trace());
    EXPECT_NEAR(OgdenLaw(kNeo, mu).At(H).energy, mu / 2 * (I1 - 3), 1e-13);
    EXPECT_NEAR(OgdenLaw(kMooney, mu).At(H).energy, mu / 2 * (0.75 * (I1 - 3) + 0.25 * (I2 - 3)),
                1e-13);
  }
}

// --- a block of 1 m under uniform dead loads on some faces, sliding on the planes opposite to them
class LoadedBlock {
 public:
  explicit LoadedBlock(const std::vector<OgdenTerm>& terms) {
    SolidModel::Params params{.options = {.law = Law::kOgden, .terms = terms, .residual = 1e-9},
                              .young_modulus = 1e5,
                              .poisson_ratio = 0.4999,
                              .range = 10};
    HeldNodes held;
    for (const Vector3d& p : mesh_.nodes) held.push_back({p.x() == 0, p.y() == 0, p.z() == 0});
    model_ = std::make_unique<SolidModel>(mesh_, held, params);
  }
  static double mu() { return 1e5 / (2 * 1.4999); }

  // Stretch along x under nominal stress on the faces across the first `axes` axes.
  double StretchUnder(double nominal, int axes) {
    const SurfaceMesh surface = SurfaceOf(mesh_);
    std::vector<Contact> contacts;
    for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
      const Vector3d centroid = Centroid(surface, t);
      for (int axis = 0; axis < axes; ++axis) {
        if (centroid[axis] < 1 - 1e-9) continue;
        Contact contact = Push(centroid, nominal * Area(surface, t) * Vector3d::Unit(axis), 1e-9);
        contact.element = t;
        contacts.push_back(contact);
      }
    }
    std::vector<ContactResponse> responses(contacts.size());
    model_->Respond(contacts, responses);
    EXPECT_TRUE(model_->failure().empty()) << model_->failure();
    return 1 + model_->displacement(NodeAt(*model_, 1, {1, 1, 1})).x();
  }

 private:
  SolidMesh mesh_ = MeshBox({1, 1, 1}, {2, 2, 2});
  std::unique_ptr<SolidModel> model_;
};

// Ogden 1972: nominal stress under free faces, incompressible. At nu = 0.4999 the volume changes by
// stress / bulk modulus, some 1e-3 at most here.
double Nominal(const std::vector<OgdenTerm>& terms, double stretch, double free_power) {
  double sum = 0;
  for (const OgdenTerm& term : terms) {
    const double a = term.exponent;
    sum += 2 * term.share * LoadedBlock::mu() / a *
           (std::pow(stretch, a - 1) - std::pow(stretch, -free_power * a - 1));
  }
  return sum;
}

TEST(OgdenBlock, FollowsTheClosedFormsOfUniaxialAndEquibiaxialLoad) {
  for (const auto& terms : {kRubber, kNeo, kMooney}) {
    LoadedBlock block(terms);
    for (const double stretch : {0.6, 1.3, 1.8}) {
      EXPECT_NEAR(block.StretchUnder(Nominal(terms, stretch, 0.5), 1) / stretch, 1, 2e-3);
    }
    for (const double stretch : {0.8, 1.15, 1.3}) {
      EXPECT_NEAR(block.StretchUnder(Nominal(terms, stretch, 2), 2) / stretch, 1, 2e-3);
    }
  }
}

}  // namespace
}  // namespace palpate
